#include "orchestrator/tasks/retarget.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "formats/error.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

constexpr const char* kVersion = "retarget 1";  ///< raised whenever the same input gives other files

struct RetargetArguments {
  std::optional<std::string> motion, rig, output, format, head;
  std::vector<std::string> subjects, more_subjects;  ///< the first behind --to, and the words after it
  bool is_all = false;
  std::optional<int> level;
  std::optional<double> fps;
};

RetargetFormat format_of(const RetargetArguments& arguments) {
  const std::string name = arguments.format.value_or(arguments.output ? "glb" : "none");
  if (name != "none" && !arguments.output)
    throw UsageError("--format " + name + " needs a folder: -o FOLDER");
  if (name == "glb") return RetargetFormat::kGlb;
  if (name == "obj") return RetargetFormat::kObj;
  if (name == "none") return RetargetFormat::kNone;
  throw UsageError("--format " + name + " is not glb, obj or none");
}

/// What has been written for one subject. A mark beside the files says from what they were made and how long
/// they are: FILE.part while they are being written, about once a second, so that an interrupted run
/// continues.
class WrittenFiles {
 public:
  WrittenFiles(Session& session, std::filesystem::path folder, std::filesystem::path mark, std::string key)
      : session_(session), folder_(std::move(folder)), mark_(std::move(mark)), key_(std::move(key)) {
    if (const auto files = read_mark(session, folder_, part(), key_)) files_ = *files;
  }

  /// The mark has the key, and every file it names is there with its length.
  static bool is_done(const Session& session, const std::filesystem::path& folder,
                      const std::filesystem::path& mark, const std::string& key) {
    return read_mark(session, folder, mark, key).has_value();
  }

  std::optional<std::size_t> find(const std::string& name) const {
    const auto found = files_.find(name);
    return found == files_.end() ? std::nullopt : std::optional(found->second);
  }

  void write(const std::string& name, const std::string& bytes) {
    session_.environment().stop.throw_if_requested();
    write_output_files(session_, {{folder_ / name, bytes}});
    files_[name] = bytes.size();
    const auto now = std::chrono::steady_clock::now();
    if (now - last_mark_ < std::chrono::seconds(1)) return;
    last_mark_ = now;
    write_output_files(session_, {{part(), text()}});
  }

  void finish() {
    write_output_files(session_, {{mark_, text()}});
    session_.files().remove_file(part());
  }

 private:
  using Lengths = std::map<std::string, std::size_t>;

  static std::optional<Lengths> read_mark(const Session& session, const std::filesystem::path& folder,
                                          const std::filesystem::path& mark, const std::string& key) {
    if (!session.files().find_status(mark)) return std::nullopt;
    std::istringstream lines(session.files().read_file(mark, 1 << 28));
    std::string line;
    if (!std::getline(lines, line) || line != key) return std::nullopt;
    Lengths files;
    while (std::getline(lines, line)) {
      const std::size_t space = line.rfind(' ');
      if (space == std::string::npos) return std::nullopt;
      const auto status = session.files().find_status(folder / line.substr(0, space));
      if (!status || std::to_string(status->size_bytes) != line.substr(space + 1)) return std::nullopt;
      files[line.substr(0, space)] = status->size_bytes;
    }
    return files;
  }

  std::string text() const {
    std::string text = key_ + "\n";
    for (const auto& [name, size] : files_) text += name + " " + std::to_string(size) + "\n";
    return text;
  }
  std::filesystem::path part() const { return mark_.string() + ".part"; }

  Session& session_;
  const std::filesystem::path folder_, mark_;
  const std::string key_;
  Lengths files_;
  std::chrono::steady_clock::time_point last_mark_ = std::chrono::steady_clock::now();
};

/// One run: what is shared, and a loop over subjects on several threads.
class RetargetRun {
 public:
  RetargetRun(const RetargetArguments& arguments, Session& session)
      : arguments_(arguments),
        session_(session),
        store_(session.open_store()),
        format_(format_of(arguments)) {
    head_files_ = session.load_head(arguments.head);
    Deformation rig = load_rig(session, *arguments.rig);
    check_same_template(rig.template_digest, head_files_, *arguments.rig);
    Motion motion = load_motion(session, *arguments.motion);
    report_gaps(motion);
    if (arguments.fps) motion = resample_motion(motion, *arguments.fps);
    ParameterTrack track = map_motion(rig, motion);
    report_track(track);
    const RigPaths paths = rig_paths(*arguments.rig);
    key_text_ = std::string(kVersion) + "\nlevel " + std::to_string(arguments.level.value_or(2)) +
                "\nformat " + arguments.format.value_or("glb") + "\nfps " +
                fmt::format("{}", arguments.fps.value_or(0));
    for (const std::filesystem::path& path :
         {paths.json, paths.exr, std::filesystem::path(*arguments.motion)})
      key_text_.append("\n").append(compute_digest(read_input_file(session, path)).hex());
    plan_ = std::make_unique<RetargetPlan>(std::move(rig), load_control_mesh(head_files_), std::move(track),
                                           arguments.level.value_or(2));
  }

  int run(std::vector<std::string> subjects) {
    if (arguments_.output && !session_.globals().is_dry_run)
      session_.files().make_folders(std::filesystem::absolute(*arguments_.output));
    const auto start = std::chrono::steady_clock::now();
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const std::size_t wanted =
        session_.globals().threads.value_or(0) > 0 ? session_.globals().threads.value_or(1) : cores;
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < std::min(wanted, subjects.size()); ++t)
      threads.emplace_back([&] { work(subjects); });
    for (std::thread& thread : threads) thread.join();
    session_.environment().stop.throw_if_requested();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report_total(subjects.size(), seconds);
    return failed_ == 0                                   ? kExitDone
           : failed_ == static_cast<int>(subjects.size()) ? last_code_
                                                          : kExitSomeFailed;
  }

 private:
  void work(const std::vector<std::string>& subjects) {
    for (std::size_t i = next_++; i < subjects.size(); i = next_++) {
      if (session_.environment().stop.signal() != 0) return;
      try {
        run_subject(subjects[i]);
      } catch (...) {
        const Failure failure = describe_failure(std::current_exception());
        const std::lock_guard lock(mutex_);
        ++failed_;
        last_code_ = failure.code;
        session_.reporter().failure({subjects[i], "retarget"}, failure);
      }
    }
  }

  void run_subject(const std::string& subject) {
    const std::string reference = subject + "/subdivide/head.glb";
    const std::string key =
        compute_digest(key_text_ + "\n" + find_referenced_object(session_, store_, reference).digest.hex())
            .hex();
    const std::filesystem::path folder = std::filesystem::absolute(arguments_.output.value_or("."));
    const std::filesystem::path mark = folder / ("." + subject + ".retarget");
    if (format_ != RetargetFormat::kNone && WrittenFiles::is_done(session_, folder, mark, key))
      return print_kept(subject);
    if (session_.globals().is_dry_run) return print_line(subject, "would be retargeted", {});
    const HeadAsset head = load_fitted_head(session_, store_, subject);
    check_same_template(head.template_digest, head_files_, subject);
    if (format_ == RetargetFormat::kObj) session_.files().make_folders(folder / subject);
    WrittenFiles written(session_, folder, mark, key);
    const RetargetPlan::Outcome outcome =
        plan_->run(subject, head, format_,
                   {[&](const std::string& name, const std::string& bytes) { written.write(name, bytes); },
                    [&](const std::string& name) { return written.find(name); }});
    if (format_ != RetargetFormat::kNone) written.finish();
    frames_ += outcome.figures.frames;
    const MotionFigures& figures = outcome.figures;
    std::string text =
        fmt::format("{} frames, largest way {:.2f} mm in frame {}, mean {:.3f} mm", figures.frames,
                    figures.largest_mm, figures.largest_frame, figures.mean_mm);
    if (format_ == RetargetFormat::kGlb)
      text += fmt::format(", morph targets within {:.2f} mm", outcome.morph_error_mm);
    print_line(subject, text,
               {{"frames", figures.frames},
                {"largest_mm", figures.largest_mm},
                {"largest_frame", figures.largest_frame},
                {"mean_mm", figures.mean_mm},
                {"morph_error_mm", outcome.morph_error_mm},
                {"bytes", outcome.bytes}});
  }

  void print_kept(const std::string& subject) { print_line(subject, "kept", {{"kept", true}}); }

  void print_line(const std::string& subject, const std::string& text, const ordered_json& members) {
    const std::lock_guard lock(mutex_);
    session_.print(subject + ": " + text);
    ordered_json line = {{"type", "retarget"}, {"subject", subject}};
    line.update(members);
    session_.print_json(line);
  }

  void report_gaps(const Motion& motion) {
    for (const MotionGap& gap : motion.gaps)
      session_.reporter().note({"motion", "retarget"},
                               fmt::format("{}: {} frames are missing after frame {}", *arguments_.motion,
                                           gap.missing_frames, gap.after_frame));
  }

  void report_track(const ParameterTrack& track) {
    std::string names;
    for (const std::string& name : track.unused) names.append(names.empty() ? "" : " ").append(name);
    if (!names.empty())
      session_.reporter().note({"motion", "retarget"}, "the rig has no control for: " + names);
    if (track.clamped_values > 0)
      session_.reporter().note(
          {"", "retarget"},
          fmt::format("{} values beyond their parameter's range were cut", track.clamped_values));
  }

  void report_total(std::size_t subjects, double seconds) {
    const double rate = static_cast<double>(frames_) / std::max(seconds, 1e-9);
    session_.print(fmt::format("{} subjects, {} vertices, {} subject-frames in {:.2f} s: {:.0f} a second",
                               subjects, plan_->vertex_count(), frames_.load(), seconds, rate));
    session_.print_json({{"type", "retarget_total"},
                         {"subjects", subjects},
                         {"vertices", plan_->vertex_count()},
                         {"subject_frames", frames_.load()},
                         {"seconds", seconds},
                         {"failed", failed_}});
  }

  const RetargetArguments& arguments_;
  Session& session_;
  Store store_;
  RetargetFormat format_;
  TemplateFiles head_files_;
  std::string key_text_;
  std::unique_ptr<RetargetPlan> plan_;
  std::mutex mutex_;
  std::atomic<std::size_t> next_ = 0, frames_ = 0;
  int failed_ = 0, last_code_ = kExitFailed;
};

int run_retarget(const RetargetArguments& arguments, Session& session) {
  std::vector<std::string> subjects = arguments.subjects;
  subjects.insert(subjects.end(), arguments.more_subjects.begin(), arguments.more_subjects.end());
  if (arguments.is_all != subjects.empty()) throw UsageError("either --to SUBJECT... or --all");
  const int level = arguments.level.value_or(2);
  if (level < 0 || level > 6) throw UsageError("--level is not from 0 to 6");
  if (arguments.is_all) subjects = session.open_store().list_subjects();
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    if (std::count(subjects.begin(), subjects.end(), subjects[i]) > 1)
      throw UsageError("subject '" + subjects[i] + "' twice");
  }
  if (subjects.empty()) throw UsageError("the store has no subjects");
  return RetargetRun(arguments, session).run(std::move(subjects));
}

}  // namespace

Command make_retarget_command() {
  Command command{
      "retarget", "play a motion on fitted heads: animated .glb, .obj sequences, or figures only", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<RetargetArguments>();
    options.add_text("--motion", arguments->motion, "curves: Live Link Face .csv, plain .csv or .json");
    options.require("--motion");
    options.add_text("--rig", arguments->rig, "rig.json, with rig.exr beside it");
    options.require("--rig");
    options.add_texts("--to", arguments->subjects, "the subjects");
    options.add_positionals("SUBJECT", arguments->more_subjects, "more subjects: --to dev00 dev01 ...");
    options.add_flag("--all", arguments->is_all, "every subject of the store");
    options.add_text("-o,--output", arguments->output, "folder for the animations; without it figures only");
    options.add_text("--format", arguments->format, "glb (default with -o), obj (a file a frame) or none");
    options.add_integer("--level", arguments->level, "level of subdivision, 0 to 6 (default 2)");
    options.add_number("--fps", arguments->fps, "resample the motion to so many frames a second");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      int code = kExitDone;
      with_threads(session.globals().threads.value_or(0), [&] { code = run_retarget(*arguments, session); });
      return code;
    };
  };
  return command;
}

}  // namespace phiz
