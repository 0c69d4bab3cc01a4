#include "orchestrator/tasks/nouns.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "stages/geometry/annotations.h"

namespace phiz {

void with_place(const std::string& place, const std::function<void()>& read) {
  try {
    read();
  } catch (const FormatError& error) {
    throw FormatError(place + ": " + error.what(), error.hint());
  } catch (const nlohmann::json::exception& error) {
    throw FormatError(place + ": " + error.what());
  }
}

std::shared_ptr<const ControlMesh> load_generic_head(TaskContext& context) {
  return context.memo().get<ControlMesh>("generic head " + context.template_digest().hex(), [&] {
    auto head = std::make_shared<ControlMesh>();
    std::istringstream mesh(context.read_input("template.obj"));
    std::istringstream annotations(context.read_input("template.json"));
    with_place(context.describe_input("template.obj"), [&] {
      *head = read_control_mesh(mesh, annotations);
      require_annotations(*head);
    });
    return head;
  });
}

PointCloud load_cloud(TaskContext& context, const std::string& input) {
  PointCloud cloud;
  std::istringstream bytes(context.read_input(input));
  with_place(context.describe_input(input), [&] { cloud = read_vdb_points(bytes); });
  return cloud;
}

std::vector<Eigen::Vector3d> load_control_positions(TaskContext& context, const std::string& input) {
  std::vector<Eigen::Vector3d> positions;
  std::istringstream mesh(context.read_input(input));
  std::istringstream annotations(context.read_input("template.json"));
  with_place(context.describe_input(input),
             [&] { positions = read_control_mesh(mesh, annotations).positions; });
  return positions;
}

nlohmann::ordered_json load_json(TaskContext& context, const std::string& input) {
  nlohmann::ordered_json object;
  with_place(context.describe_input(input),
             [&] { object = nlohmann::ordered_json::parse(context.read_input(input)); });
  return object;
}

std::shared_ptr<const ScanSurface> load_scan_surface(TaskContext& context, const std::string& cloud_input) {
  return context.memo().get<ScanSurface>("scan surface " + context.input_digest(cloud_input).hex(), [&] {
    return std::make_shared<const ScanSurface>(load_cloud(context, cloud_input));
  });
}

std::shared_ptr<const SubdivisionHierarchy> load_hierarchy(TaskContext& context, int levels) {
  const auto head = load_generic_head(context);
  return context.memo().get<SubdivisionHierarchy>(
      "hierarchy " + context.template_digest().hex() + " " + std::to_string(levels), [&] {
        const int vertex_count = static_cast<int>(head->positions.size());
        return std::make_shared<const SubdivisionHierarchy>(head->triangles, vertex_count, levels);
      });
}

void save(TaskContext& context, const std::string& output, const std::function<void(std::ostream&)>& write) {
  std::ostringstream bytes;
  write(bytes);
  context.write_output(output, std::move(bytes).str());
}

void save_json(TaskContext& context, const std::string& output, const nlohmann::ordered_json& object) {
  context.write_output(output, format_json_output(object));
}

std::string format_json_output(const nlohmann::ordered_json& object) {
  return object.dump(1) + "\n";
}

void save_control_positions(TaskContext& context, const std::string& output,
                            const std::vector<Eigen::Vector3d>& positions) {
  ControlMesh mesh = *load_generic_head(context);
  mesh.positions = positions;
  std::ostringstream annotations;  // the generic head's own, not kept again
  save(context, output, [&](std::ostream& out) { write_control_mesh(mesh, out, annotations); });
}

nlohmann::ordered_json to_json(const Eigen::Matrix4d& matrix) {
  auto rows = nlohmann::ordered_json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  }
  return rows;
}

Eigen::Matrix4d matrix_from_json(const nlohmann::ordered_json& rows) {
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix(row, column) = rows.at(row).at(column).get<double>();
  }
  return matrix;
}

}  // namespace phiz
