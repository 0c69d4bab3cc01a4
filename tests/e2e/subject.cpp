#include "tests/e2e/subject.h"

#include <bit>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace phiz::test {
namespace {

namespace fs = std::filesystem;

void require_success(const ProgramRun& run, const std::string& what) {
  if (run.exit_code == 0) return;
  throw std::runtime_error(what + " ended with " + std::to_string(run.exit_code) + ": " + run.err);
}

}  // namespace

FittedSubject fitted_subject() {
  const fs::path folder = PHIZ_E2E_FOLDER;
  const FittedSubject subject{folder / "scans/synth007.ply", folder / "truth/synth007.ply", folder / "store"};
  if (!fs::exists(folder / "subjects.json")) {
    fs::create_directories(folder);
    require_success(run_program({phiz_program().string(), "synth", "-o", folder.string(), "--seed", "7",
                                 "--points", "100000", "-q"}),
                    "phiz synth");
  }
  require_success(run_phiz(subject.store, {"fit", subject.scan.string(), "-q"}), "phiz fit");
  return subject;
}

void copy_store(const fs::path& to) {
  fs::copy(fitted_subject().store, to, fs::copy_options::recursive);
}

ProgramRun run_phiz(const fs::path& store, std::vector<std::string> arguments, ProgramOptions options) {
  arguments.insert(arguments.begin(), phiz_program().string());
  arguments.insert(arguments.end(), {"--store", store.string()});
  if (options.folder.empty()) options.folder = store.parent_path();
  return run_program(arguments, options);
}

int count_lines(const std::string& text, const std::string& start) {
  int count = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) count += line.starts_with(start);
  return count;
}

std::string list_digests(const fs::path& store) {
  const ProgramRun run = run_phiz(store, {"store", "ls"});
  require_success(run, "phiz store ls");
  return run.out;
}

void write_binary_ply(const fs::path& file, const std::vector<Eigen::Vector3f>& points) {
  static_assert(std::endian::native == std::endian::little);
  std::ofstream out(file, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  out.write(reinterpret_cast<const char*>(points.data()),
            static_cast<std::streamsize>(points.size() * sizeof(Eigen::Vector3f)));
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string read_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace phiz::test
