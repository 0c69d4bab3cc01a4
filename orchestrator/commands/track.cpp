#include "stages/retarget/track.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <chrono>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/scan_file.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/work_journal.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

struct TrackArguments {
  std::optional<std::string> scans, rig, subject, output, frame, head;
  std::optional<double> fps;
  std::optional<int> points;
};

/// One path a line, relative to the list; empty lines and those that begin with # are passed over.
std::vector<std::filesystem::path> read_list(const Session& session, const std::filesystem::path& list) {
  std::istringstream lines(read_input_file(session, list));
  std::vector<std::filesystem::path> scans;
  for (std::string line; std::getline(lines, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line[0] == '#' || line == "scan") continue;
    scans.push_back(list.parent_path() / line);
  }
  if (scans.empty()) throw FormatError(list.string() + ": names no scan", "one path a line");
  return scans;
}

std::vector<Eigen::Vector3f> read_points(const Session& session, const std::filesystem::path& path,
                                         const Eigen::Matrix4d& head_from_scan) {
  const std::string bytes = read_input_file(session, path);
  ScanFile scan;
  with_place(path.string(),
             [&] { scan = parse_scan(std::as_bytes(std::span(bytes)), path.extension().string()); });
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector3f& p : scan.points.positions) {
    const Eigen::Vector4d place = head_from_scan * (scan.origin + p.cast<double>()).homogeneous();
    points.push_back(place.head<3>().cast<float>());
  }
  return points;
}

Motion start_motion(const Deformation& rig, double fps) {
  Motion motion;
  motion.frames_per_second = fps;
  for (const RigControl& control : rig.controls) motion.names.push_back(control.name);
  for (const char* name :
       {"HeadTurnX_rad", "HeadTurnY_rad", "HeadTurnZ_rad", "HeadX_mm", "HeadY_mm", "HeadZ_mm"})
    motion.names.emplace_back(name);
  return motion;
}

void add_frame(Motion& motion, const TrackedFrame& frame) {
  motion.times_s.push_back(static_cast<double>(motion.times_s.size()) / motion.frames_per_second);
  motion.values.insert(motion.values.end(), frame.controls.begin(), frame.controls.end());
  const Eigen::AngleAxisd turn(frame.scan_from_head.rotation());
  const Eigen::Vector3d axis = turn.angle() * turn.axis(), place = frame.scan_from_head.translation();
  for (const double value : {axis.x(), axis.y(), axis.z(), place.x(), place.y(), place.z()})
    motion.values.push_back(static_cast<float>(value));
}

constexpr const char* kVersion = "track 1";  ///< raised whenever the same input gives another motion

/// What has been tracked, by the digests of the scans so far, written down about once a second.
class TrackedSoFar {
 public:
  TrackedSoFar(WorkJournal& journal, std::size_t controls, bool writes)
      : journal_(journal), row_(controls + kMore), writes_(writes) {
    const auto bytes = journal.find("frames");
    const std::size_t size = Digest{}.bytes.size() + row_ * sizeof(double);
    if (!bytes || bytes->size() % size != 0) return;
    for (std::size_t at = 0; at < bytes->size(); at += size) {
      Entry entry{{}, std::vector<double>(row_)};
      std::memcpy(entry.scan.bytes.data(), bytes->data() + at, entry.scan.bytes.size());
      std::memcpy(entry.numbers.data(), bytes->data() + at + entry.scan.bytes.size(), row_ * sizeof(double));
      entries_.push_back(std::move(entry));
    }
  }

  /// The frame if it and all before it were tracked from these very scans.
  std::optional<TrackedFrame> find(std::size_t frame_idx, const Digest& scan) {
    if (frame_idx >= entries_.size()) return std::nullopt;
    if (entries_[frame_idx].scan != scan) {
      entries_.resize(frame_idx);
      return std::nullopt;
    }
    const std::vector<double>& numbers = entries_[frame_idx].numbers;
    TrackedFrame frame;
    frame.controls.assign(numbers.begin(), numbers.end() - kMore);
    const double* more = numbers.data() + numbers.size() - kMore;
    frame.scan_from_head.matrix() = Eigen::Map<const Eigen::Matrix4d>(more);
    frame.residual_mm = more[16];
    frame.matches = static_cast<int>(more[17]);
    return frame;
  }

  void add(const Digest& scan, const TrackedFrame& frame) {
    std::vector<double> numbers(frame.controls.begin(), frame.controls.end());
    const Eigen::Matrix4d& matrix = frame.scan_from_head.matrix();
    numbers.insert(numbers.end(), matrix.data(), matrix.data() + 16);
    numbers.insert(numbers.end(), {frame.residual_mm, static_cast<double>(frame.matches)});
    entries_.push_back({scan, std::move(numbers)});
    const auto now = std::chrono::steady_clock::now();
    if (!writes_ || now - last_save_ < std::chrono::seconds(1)) return;
    last_save_ = now;
    std::string bytes;
    for (const Entry& entry : entries_) {
      bytes.append(reinterpret_cast<const char*>(entry.scan.bytes.data()), entry.scan.bytes.size());
      bytes.append(reinterpret_cast<const char*>(entry.numbers.data()), row_ * sizeof(double));
    }
    journal_.keep("frames", bytes);
  }

 private:
  static constexpr std::size_t kMore = 18;  // pose, residual, matches
  struct Entry {
    Digest scan;
    std::vector<double> numbers;
  };
  WorkJournal& journal_;
  const std::size_t row_;
  const bool writes_;
  std::vector<Entry> entries_;
  std::chrono::steady_clock::time_point last_save_ = std::chrono::steady_clock::now();
};

std::string describe_work(const TrackArguments& arguments, const TemplateFiles& files, const Store& store,
                          const Session& session) {
  const RigPaths rig = rig_paths(*arguments.rig);
  std::string text = std::string(kVersion) + "\n" + files.digest.hex() +
                     fmt::format("\n{} {}", arguments.frame.value_or("scan"), arguments.points.value_or(0));
  for (const std::filesystem::path& path : {rig.json, rig.exr})
    text += "\n" + compute_digest(read_input_file(session, path)).hex();
  return text + "\n" +
         find_referenced_object(session, store, *arguments.subject + "/subdivide/head.glb").digest.hex();
}

int run_track(const TrackArguments& arguments, Session& session) {
  const double fps = arguments.fps.value_or(30);
  if (!(fps > 0 && fps <= 1000)) throw UsageError("--fps is not above 0, up to 1000");
  const std::string frame_name = arguments.frame.value_or("scan");
  if (frame_name != "scan" && frame_name != "head")
    throw UsageError("--frame " + frame_name + " is not scan or head");
  TrackOptions options;
  options.points = arguments.points.value_or(options.points);
  if (options.points < 1000) throw UsageError("--points is below 1000");
  const TemplateFiles files = session.load_head(arguments.head);
  const ControlMesh head = load_control_mesh(files);
  const Deformation rig = load_rig(session, *arguments.rig);
  check_same_template(rig.template_digest, files, *arguments.rig);
  const std::vector<std::filesystem::path> scans = read_list(session, *arguments.scans);
  const Store store = session.open_store();
  const HeadAsset asset = load_fitted_head(session, store, *arguments.subject);
  check_same_template(asset.template_digest, files, *arguments.subject);
  const Eigen::Matrix4d head_from_scan =
      frame_name == "head" ? Eigen::Matrix4d::Identity() : asset.scan_from_head.inverse().eval();
  const NeutralMaker maker(head, 2);
  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& p : asset.positions) control.push_back(p.cast<double>());
  Tracker tracker(rig, head, maker, maker.make(control, asset.displacements_mm), options);
  Motion motion = start_motion(rig, fps);
  WorkJournal journal(store, describe_work(arguments, files, store, session));
  TrackedSoFar so_far(journal, rig.controls.size(), !session.globals().is_dry_run);
  for (const std::filesystem::path& scan : scans) {
    session.environment().stop.throw_if_requested();
    TrackedFrame frame;
    const Digest digest = hash_scan(session.files(), scan).digest;
    if (const auto found = so_far.find(motion.frame_count(), digest)) {
      frame = *found;
      tracker.resume(frame);
    } else {
      const std::vector<Eigen::Vector3f> points = read_points(session, scan, head_from_scan);
      with_place(scan.string(), [&] { frame = tracker.track(points); });
      so_far.add(digest, frame);
    }
    add_frame(motion, frame);
    session.print(
        fmt::format("{}: {} matches, residual {:.3f} mm", scan.string(), frame.matches, frame.residual_mm));
    session.print_json({{"type", "track"},
                        {"scan", scan.string()},
                        {"matches", frame.matches},
                        {"residual_mm", frame.residual_mm},
                        {"scan_from_head", to_json(Eigen::Matrix4d(frame.scan_from_head.matrix()))}});
  }
  std::ostringstream out;
  if (arguments.output->ends_with(".json"))
    write_motion_json(motion, out);
  else
    write_motion_csv(motion, out);
  if (!session.globals().is_dry_run) write_output_files(session, {{*arguments.output, std::move(out).str()}});
  if (!session.globals().is_dry_run) journal.forget();
  session.print(fmt::format("{}: {} frames", *arguments.output, motion.frame_count()));
  session.print_json({{"type", "motion"}, {"path", *arguments.output}, {"frames", motion.frame_count()}});
  return kExitDone;
}

}  // namespace

Command make_track_command() {
  Command command{
      "track", "a sequence of scans of a fitted head into a motion file: controls and pose a frame", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<TrackArguments>();
    options.add_text("--scans", arguments->scans, "a text file with one scan a line, in order");
    options.require("--scans");
    options.add_text("--rig", arguments->rig, "rig.json, with rig.exr beside it");
    options.require("--rig");
    options.add_text("--subject", arguments->subject, "the fitted head");
    options.require("--subject");
    options.add_text("-o,--output", arguments->output, "the motion: .csv or .json");
    options.require("--output");
    options.add_number("--fps", arguments->fps, "frames a second of the scans (default 30)");
    options.add_text("--frame", arguments->frame,
                     "the scans' frame: scan (as the subject's own scan; default) or head");
    options.add_integer("--points", arguments->points, "points of a scan that are looked at (default 40000)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      int code = kExitDone;
      with_threads(session.globals().threads.value_or(0), [&] { code = run_track(*arguments, session); });
      return code;
    };
  };
  return command;
}

}  // namespace phiz
