#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/geometry_image.h"
#include "formats/shape_space.h"
#include "orchestrator/commands/fields.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/work_journal.h"
#include "stages/deform/pca.h"
#include "stages/geometry/parallel.h"
#include "stages/unwrap/unwrap.h"

namespace phiz {
namespace {

constexpr int kLevel = 4;

struct PcaArguments {
  std::vector<std::string> subjects;
  std::optional<std::string> output, head;
  std::optional<int> components, side;
  bool takes_all = false;
};

struct ShapeArguments {
  std::string space;
  std::optional<std::string> subject, fill, coefficients, output, head;
  std::optional<int> components;
};

/// Heads of the store as vectors over a grid, brought onto the generic head by a rigid motion.
class ShapeReader {
 public:
  ShapeReader(const ControlMesh& head, int side)
      : head_(head), side_(side), chart_(make_uv_chart(head.uv, head.triangles, kLevel)) {}

  std::vector<float> read(const HeadAsset& asset) const {
    std::vector<Eigen::Vector3d> control;
    for (const Eigen::Vector3f& p : asset.positions) control.push_back(p.cast<double>());
    if (control.size() != head_.positions.size())
      throw UsageError("the subject was fitted with another generic head");
    const Eigen::Isometry3d motion = find_rigid_alignment(control, head_.positions);
    const auto levels = std::span(asset.displacements_mm)
                            .first(std::min<std::size_t>(asset.displacements_mm.size(), kLevel + 1));
    const UvSurface surface(chart_, evaluate_surface(chart_.hierarchy, control, levels, kLevel));
    std::vector<float> vector(3 * static_cast<std::size_t>(side_) * side_);
    parallel_for(static_cast<std::size_t>(side_), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t y = begin; y < end; ++y) {
        for (int x = 0; x < side_; ++x) {
          const Eigen::Vector3d p = motion * surface.position_at(uv(x, static_cast<int>(y)));
          for (int axis = 0; axis < 3; ++axis)
            vector[3 * (y * side_ + x) + axis] = static_cast<float>(p[axis]);
        }
      }
    });
    return vector;
  }

  /// Area of the generic head about each node.
  std::vector<float> weights() const {
    const UvSurface surface(chart_, evaluate_surface(chart_.hierarchy, head_.positions, {}, kLevel));
    std::vector<float> areas;
    const double cell = 1.0 / ((side_ - 1.0) * (side_ - 1.0));
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const UvSample there = surface.evaluate(uv(x, y));
        areas.push_back(static_cast<float>(cell * there.du.cross(there.dv).norm() + 1e-9));
      }
    }
    return areas;
  }

 private:
  Eigen::Vector2d uv(int x, int y) const { return {x / (side_ - 1.0), 1 - y / (side_ - 1.0)}; }

  const ControlMesh& head_;
  int side_;
  UvChart chart_;
};

std::vector<float> three_times(const std::vector<float>& values) {
  std::vector<float> result;
  result.reserve(3 * values.size());
  for (const float value : values) result.insert(result.end(), 3, value);
  return result;
}

ShapeModel model_of(const ShapeSpace& space) {
  return {three_times(space.weights), space.mean, space.components, space.variances, space.total_variance};
}

/// Weighted root mean square distance of nodes, mm.
double distance_mm(const std::vector<float>& weights, const std::vector<float>& a,
                   const std::vector<float>& b) {
  double sum = 0, area = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += double{weights[i / 3]} * (double{a[i]} - b[i]) * (double{a[i]} - b[i]);
    area += i % 3 == 0 ? weights[i / 3] : 0;
  }
  return std::sqrt(sum / area);
}

ShapeSpace load_space(const Session& session, const std::string& name, const TemplateFiles& files) {
  const RigPaths paths = rig_paths(name);
  std::istringstream json(read_input_file(session, paths.json)), exr(read_input_file(session, paths.exr));
  ShapeSpace space;
  with_place(paths.json.string(), [&] { space = read_shape_space(json, exr); });
  check_same_template(space.template_digest, files, paths.json.string());
  return space;
}

/// The components so far, written down about every other second, and less often where that takes long itself.
class PcaSoFar {
 public:
  PcaSoFar(const Store& store, const std::string& work, bool writes)
      : journal_(store, work), writes_(writes) {}

  /// How many shapes the components of an interrupted run hold already.
  std::size_t restore(StreamingPca& pca) {
    const auto bytes = journal_.find("components");
    return bytes && pca.restore(*bytes) ? pca.count() : 0;
  }

  void keep(const StreamingPca& pca) {
    const auto begin = Clock::now();
    if (!writes_ || begin - last_ < std::max<Clock::duration>(std::chrono::milliseconds(1500), 5 * cost_))
      return;
    journal_.keep("components", pca.encode());
    last_ = Clock::now();
    cost_ = last_ - begin;
  }

  void forget() {
    if (writes_) journal_.forget();
  }

 private:
  using Clock = std::chrono::steady_clock;
  WorkJournal journal_;
  const bool writes_;
  Clock::time_point last_ = Clock::now();
  Clock::duration cost_{};
};

/// What the components are made from: shapes in this order, on this grid.
std::string describe_work(const std::vector<std::string>& names, const ShapeSpace& space, int components,
                          const Store& store, const Session& session) {
  constexpr const char* kVersion = "pca 1";  // raised whenever the same input gives other components
  std::string text = fmt::format("{}\n{}\n{} {}", kVersion, space.template_digest, space.width, components);
  for (const std::string& name : names)
    text += "\n" + find_referenced_object(session, store, name + "/subdivide/head.glb").digest.hex();
  return text;
}

/// The subjects asked for, each once, sorted.
std::vector<std::string> list_names(const PcaArguments& arguments, const Store& store) {
  std::vector<std::string> names = arguments.subjects;
  if (arguments.takes_all) names = store.list_subjects();
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  if (names.size() < 2) throw UsageError("principal components need two subjects at least");
  return names;
}

void run_pca(const PcaArguments& arguments, Session& session) {
  const int side = arguments.side.value_or(256), components = arguments.components.value_or(64);
  if (side < 16 || side > 4096) throw UsageError("--side is not from 16 to 4096");
  if (components < 1 || components > 1000) throw UsageError("--components is not from 1 to 1000");
  const TemplateFiles files = session.load_head(arguments.head);
  const ControlMesh head = load_control_mesh(files);
  const Store store = session.open_store();
  const std::vector<std::string> names = list_names(arguments, store);
  const ShapeReader reader(head, side);
  ShapeSpace space;
  space.template_digest = files.digest.hex();
  space.width = space.height = side;
  space.weights = reader.weights();
  StreamingPca pca(three_times(space.weights), components);
  const auto read = [&](const std::string& name) {
    const HeadAsset asset = load_fitted_head(session, store, name);
    check_same_template(asset.template_digest, files, name);
    session.environment().stop.throw_if_requested();
    return reader.read(asset);
  };
  PcaSoFar so_far(store, describe_work(names, space, components, store, session),
                  !session.globals().is_dry_run);
  for (std::size_t i = so_far.restore(pca); i < names.size(); ++i) {
    pca.add(read(names[i]));
    so_far.keep(pca);
  }
  pca.finish();
  ShapeModel model = make_shape_model(pca);
  for (const std::string& name : names) {
    const std::vector<float> shape = read(name);  // once more: never all in memory
    const std::vector<double> coefficients = project(model, shape);
    const double left_mm = distance_mm(space.weights, synthesise(model, coefficients), shape);
    session.print(fmt::format("{}: {:.4f} mm left", name, left_mm));
    session.print_json(
        {{"type", "shape"}, {"subject", name}, {"left_mm", left_mm}, {"coefficients", coefficients}});
    space.subjects[name] = coefficients;
  }
  double explained = 0;
  for (std::size_t k = 0; k < model.variances.size(); ++k) {
    explained += model.variances[k];
    session.print(fmt::format("component {}: {:.2f} % of the variance, {:.2f} % with those before", k,
                              100 * model.variances[k] / model.total_variance,
                              100 * explained / model.total_variance));
  }
  space.mean = std::move(model.mean);
  space.components = std::move(model.components);
  space.variances = model.variances;
  space.total_variance = model.total_variance;
  std::ostringstream json, exr;
  write_shape_space(space, json, exr);
  const RigPaths paths = rig_paths(*arguments.output);
  if (!session.globals().is_dry_run)
    write_output_files(session, {{paths.json, std::move(json).str()}, {paths.exr, std::move(exr).str()}});
  so_far.forget();
  session.print_json({{"type", "space"},
                      {"json", paths.json.string()},
                      {"exr", paths.exr.string()},
                      {"variances", space.variances},
                      {"total_variance", space.total_variance}});
}

std::vector<double> parse_numbers(const std::string& text) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    std::size_t used = 0;
    double number = 0;
    try {
      number = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || used != word.size() || !std::isfinite(number))
      throw UsageError("--coefficients: '" + word + "' is not a number");
    numbers.push_back(number);
  }
  return numbers;
}

/// Coefficients of a geometry image where it is known (confidence above 0).
std::vector<double> coefficients_of_image(const ShapeModel& model, const ShapeSpace& space,
                                          const Session& session, const std::string& path,
                                          std::vector<float>& shape) {
  std::istringstream in(read_input_file(session, path));
  GeometryImage image;
  with_place(path, [&] { image = read_geometry_image(in); });
  if (image.width != space.width || image.height != space.height)
    throw UsageError(path + " is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                         ", the space " + std::to_string(space.width) + " x " + std::to_string(space.height),
                     "phiz export SUBJECT -o FILE.exr --size " + std::to_string(space.width));
  if (image.template_digest != space.template_digest)
    throw UsageError(path + " belongs to another generic head than the space");
  std::vector<Eigen::Vector3d> from, to;
  std::vector<bool> is_known;
  for (std::size_t i = 0; i < image.node_count(); ++i) {
    const bool known = image.confidences.empty() || image.confidences[i] > 0;
    is_known.insert(is_known.end(), 3, known);
    if (!known) continue;
    from.push_back(image.positions[i].cast<double>());
    to.emplace_back(space.mean[3 * i], space.mean[3 * i + 1], space.mean[3 * i + 2]);
  }
  if (from.size() < 4) throw UsageError(path + ": next to nothing of it is known");
  const Eigen::Isometry3d motion = find_rigid_alignment(from, to);
  shape.clear();
  for (const Eigen::Vector3f& p : image.positions) {
    const Eigen::Vector3f at = (motion * p.cast<double>()).cast<float>();
    shape.insert(shape.end(), {at.x(), at.y(), at.z()});
  }
  return reconstruct(model, shape, is_known, 1.0);
}

/// A shape as a file, by its extension.
std::string make_surface_file(const std::filesystem::path& path, const ShapeSpace& space,
                              const std::vector<float>& made) {
  GeometryImage image;
  image.width = space.width;
  image.height = space.height;
  image.template_digest = space.template_digest;
  for (std::size_t i = 0; i < made.size(); i += 3)
    image.positions.emplace_back(made[i], made[i + 1], made[i + 2]);
  std::ostringstream out;
  if (path.extension() == ".exr") {
    write_geometry_image(image, out);
  } else if (path.extension() == ".ply") {
    write_ply(make_grid_mesh(image), out);
  } else if (path.extension() == ".obj") {
    write_obj(make_grid_mesh(image), out);
  } else {
    throw UsageError("cannot write a '" + path.extension().string() + "' file", "use .exr, .ply or .obj");
  }
  return std::move(out).str();
}

void run_shape(const ShapeArguments& arguments, Session& session) {
  const int sources =
      arguments.subject.has_value() + arguments.fill.has_value() + arguments.coefficients.has_value();
  if (sources != 1) throw UsageError("name one of --subject, --fill and --coefficients");
  const TemplateFiles files = session.load_head(arguments.head);
  const ShapeSpace space = load_space(session, arguments.space, files);
  const ShapeModel model = model_of(space);
  std::vector<double> coefficients;
  std::vector<float> shape;
  if (arguments.coefficients) {
    coefficients = parse_numbers(*arguments.coefficients);
    if (coefficients.size() > model.components.size())
      throw UsageError("the space has " + std::to_string(model.components.size()) + " components");
    for (std::size_t k = 0; k < coefficients.size(); ++k) coefficients[k] *= std::sqrt(model.variances[k]);
  } else if (arguments.fill) {
    coefficients = coefficients_of_image(model, space, session, *arguments.fill, shape);
  } else {
    const ControlMesh head = load_control_mesh(files);
    const HeadAsset asset = load_fitted_head(session, session.open_store(), *arguments.subject);
    check_same_template(asset.template_digest, files, *arguments.subject);
    shape = ShapeReader(head, space.width).read(asset);
    coefficients = project(model, shape);
  }
  if (arguments.components && *arguments.components >= 0 &&
      static_cast<std::size_t>(*arguments.components) < coefficients.size())
    coefficients.resize(*arguments.components);
  const std::vector<float> made = synthesise(model, coefficients);
  nlohmann::ordered_json told = {{"type", "shape"}, {"coefficients", nlohmann::ordered_json::array()}};
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    const double sigma = std::sqrt(model.variances[k]);
    told["coefficients"].push_back(sigma > 0 ? coefficients[k] / sigma : 0);
    session.print(
        fmt::format("component {}: {:+.3f} standard deviations", k, sigma > 0 ? coefficients[k] / sigma : 0));
  }
  if (!shape.empty() && !arguments.fill) {
    const double left_mm = distance_mm(space.weights, made, shape);
    session.print(fmt::format("{:.3f} mm left", left_mm));
    told["left_mm"] = left_mm;
  }
  session.print_json(told);
  if (!arguments.output || session.globals().is_dry_run) return;
  write_output_files(session, {{*arguments.output, make_surface_file(*arguments.output, space, made)}});
}

}  // namespace

Command make_fields_pca_command() {
  Command command{"pca", "principal components of fitted subjects over (u,v)", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<PcaArguments>();
    options.add_positionals("SUBJECT", arguments->subjects, "fitted subjects");
    options.add_flag("--all", arguments->takes_all, "all subjects of the store");
    options.add_text("-o,--output", arguments->output, "the space: NAME.json and NAME.exr are written");
    options.require("--output");
    options.add_integer("--components", arguments->components, "kept at most (default 64)");
    options.add_integer("--side", arguments->side, "nodes of the (u,v) grid a side (default 256)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      with_threads(session.globals().threads.value_or(0), [&] { run_pca(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

Command make_fields_shape_command() {
  Command command{"shape", "a head out of principal components: projected, filled in or made up", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<ShapeArguments>();
    options.add_positional("SPACE", arguments->space, "what phiz fields pca wrote");
    options.add_text("--subject", arguments->subject, "a fitted subject, projected");
    options.add_text("--fill", arguments->fill, "a geometry image: where its confidence is 0 it is made up");
    options.add_text("--coefficients", arguments->coefficients, "in standard deviations: 1.5,0,-2");
    options.add_integer("--components", arguments->components, "use the first so many only");
    options.add_text("-o,--output", arguments->output, "the surface as .exr, .ply or .obj");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      with_threads(session.globals().threads.value_or(0), [&] { run_shape(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace phiz
