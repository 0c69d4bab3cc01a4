#include "orchestrator/commands/template_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "orchestrator/tasks/nouns.h"
#include "store/durable_writer.h"

namespace phiz {

ControlMesh read_generic_head(const std::optional<std::string>& path, const Session& session) {
  const TemplateFiles files = session.load_head(path);
  std::istringstream mesh(files.mesh), annotations(files.annotations);
  ControlMesh head;
  with_place(files.mesh_path.string(), [&] { head = read_control_mesh(mesh, annotations); });
  return head;
}

void report_checks(const std::vector<HeadCheck>& checks, const std::string& name,
                   const std::filesystem::path& folder, const Session& session) {
  const HeadCheck* first = nullptr;
  std::size_t short_count = 0;
  for (const HeadCheck& check : checks) {
    session.print(fmt::format("{:<66} {:>24}  {:<16} {}", check.what, check.value, check.bar,
                              check.ok ? "ok" : "SHORT"));
    nlohmann::ordered_json line = {{"type", "check"},
                                   {"what", check.what},
                                   {"value", check.value},
                                   {"bar", check.bar},
                                   {"ok", check.ok}};
    if (!folder.empty()) line["picture"] = (folder / (check.picture + ".png")).string();
    session.print_json(line);
    if (check.ok) continue;
    ++short_count;
    if (first == nullptr) first = &check;
  }
  if (first == nullptr) return;
  const std::string more = short_count > 1 ? fmt::format(" (and {} more)", short_count - 1) : "";
  throw FormatError(
      fmt::format("{}: {}: {}, should be {}{}", name, first->what, first->value, first->bar, more),
      "samples/generic_head/README.md says what each check wants");
}

void write_folder(const std::filesystem::path& folder, const std::map<std::string, std::string>& contents,
                  const Session& session) {
  if (session.globals().is_dry_run) return;
  const std::filesystem::path whole = std::filesystem::absolute(folder);
  session.files().make_folders(whole);
  DurableWriter writer(session.files());
  for (const auto& [file, bytes] : contents) {
    writer.add(whole / file, std::as_bytes(std::span(bytes)), FileSystem::Mode::kWritable);
  }
  writer.publish();
}

void deliver_head(const ControlMesh& head, const std::string& folder, bool is_forced, Session& session) {
  std::ostringstream mesh, annotations;
  write_control_mesh(head, mesh, annotations);
  const auto write = [&] {
    write_folder(folder, {{"head.obj", mesh.str()}, {"head.json", annotations.str()}}, session);
  };
  if (is_forced) write();
  report_checks(check_generic_head(head), is_forced ? folder : folder + " (not written, see --force)", {},
                session);
  if (!is_forced) write();
  session.print(fmt::format("{}: {} vertices", (std::filesystem::path(folder) / "head.obj").string(),
                            head.positions.size()));
  session.print_json({{"type", "template"}, {"folder", folder}, {"vertices", head.positions.size()}});
}

}  // namespace phiz
