#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/point_cloud.h"
#include "orchestrator/task.h"
#include "stages/geometry/scan_surface.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

// Nouns out of a task's inputs. FormatError names the file or "stage/output" it came from.
std::shared_ptr<const ControlMesh> load_generic_head(TaskContext& context);
PointCloud load_cloud(TaskContext& context, const std::string& input);
std::vector<Eigen::Vector3d> load_control_positions(TaskContext& context, const std::string& input);
nlohmann::ordered_json load_json(TaskContext& context, const std::string& input);

// Made once a run and shared by the subject's stages.
std::shared_ptr<const ScanSurface> load_scan_surface(TaskContext& context, const std::string& cloud_input);
std::shared_ptr<const SubdivisionHierarchy> load_hierarchy(TaskContext& context, int levels);

// Nouns into a task's outputs.
void save(TaskContext& context, const std::string& output, const std::function<void(std::ostream&)>& write);
void save_json(TaskContext& context, const std::string& output, const nlohmann::ordered_json& object);
std::string format_json_output(const nlohmann::ordered_json& object);  ///< what save_json writes
/// An .obj with the generic head's triangles and (u,v).
void save_control_positions(TaskContext& context, const std::string& output,
                            const std::vector<Eigen::Vector3d>& positions);

nlohmann::ordered_json to_json(const Eigen::Matrix4d& matrix);  ///< four rows of four
Eigen::Matrix4d matrix_from_json(const nlohmann::ordered_json& rows);

/// Calls `read` and puts `place` before the text of a FormatError.
void with_place(const std::string& place, const std::function<void()>& read);

}  // namespace phiz
