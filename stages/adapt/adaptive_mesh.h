#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "stages/adapt/multi_triangulation.h"

namespace phiz {

/// What an adaptive mesh starts from: a compliant mesh (make_compliant) with a place in (u,v) a vertex.
struct BasePolyhedron {
  std::vector<Eigen::Vector2d> uv;
  std::vector<Eigen::Vector3i> triangles;
  int attribute_count = 0;        ///< numbers a vertex that are carried along: new vertices get the mean of
  std::vector<float> attributes;  ///< the two they split; [vertex * attribute_count + k]
};

struct VertexSample {
  Eigen::Vector3f position = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::UnitZ();
};

/// A vertex that wants a sample: in the middle of a and b, or -1, -1 (base, or the surface has changed).
struct NewVertex {
  int vertex = -1, a = -1, b = -1;
  int face = -1;  ///< the slot whose edge was split
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
};

class AdaptiveMesh;

/// The surface that a mesh adapts to. Four things are asked of it; the rest has defaults.
class AdaptiveSurface {
 public:
  virtual ~AdaptiveSurface() = default;
  virtual const BasePolyhedron& base() const = 0;
  virtual VertexSample sample(const AdaptiveMesh& mesh, const NewVertex& place) = 0;
  virtual bool should_refine(const AdaptiveMesh& mesh, int face) = 0;
  /// `weld` is what would be done (MultiTriangulation::describe_weld).
  virtual bool may_simplify(const AdaptiveMesh& mesh, const StellarChange& weld) = 0;

  /// For refinement in order: what is wrong with a face, and with the worse of the two that a weld would
  /// make.
  virtual double error(const AdaptiveMesh&, int) { return 0; }
  virtual double weld_error(const AdaptiveMesh&, const StellarChange&) {
    return std::numeric_limits<double>::infinity();
  }
  virtual void on_change(const AdaptiveMesh&, const StellarChange&) {}  ///< after each operator
  virtual void on_resample(const AdaptiveMesh&) {}  ///< after every vertex has got its sample anew
  /// False where the answer for a face depends on the face across its edge too: it is then asked again when
  /// that changes.
  virtual bool is_face_local() const { return true; }
};

struct AdaptBudget {
  int vertices = std::numeric_limits<int>::max();  ///< not exceeded, but for what a single request needs
  double error = 0;                                ///< refine_in_order stops where no face has more
  int level = 40;                                  ///< no face is split beyond, <= kMostLevel
  std::function<bool()> keep_going;  ///< asked every 64 requests; the caller's clock. May be empty
};

struct AdaptReport {
  int splits = 0, welds = 0;
  bool is_done = true;  ///< false: a budget ended it
  double error = 0;     ///< refine_in_order: of the worst face left
};

/// A mesh that follows a surface by splits and welds. A refinement or simplification may be asked for in any
/// order; what has to happen before it does. Never a crack: every state is a conforming mesh. Keeps a
/// reference to the surface. Same calls, same mesh. 80 bytes a triangle at most.
class AdaptiveMesh {
 public:
  explicit AdaptiveMesh(AdaptiveSurface& surface);  ///< throws InvalidInput as MultiTriangulation does

  AdaptReport refine(const AdaptBudget& budget = {});    ///< splits until should_refine says no everywhere
  AdaptReport simplify(const AdaptBudget& budget = {});  ///< welds until may_simplify says no everywhere
  AdaptReport adapt(const AdaptBudget& budget = {});     ///< both, to a fixed point
  /// Splits the face with the largest error first, until a budget is reached; then takes back what has become
  /// needless and spends it elsewhere.
  AdaptReport refine_in_order(const AdaptBudget& budget);
  void refine_face(int face);        ///< one request, with what it needs
  void simplify_vertex(int vertex);  ///< not of the base
  void simplify_all();               ///< back to the base
  void resample();                   ///< every vertex anew, after the surface has changed

  const MultiTriangulation& triangulation() const { return triangulation_; }
  const StellarMesh& mesh() const { return triangulation_.mesh(); }
  const Eigen::Vector2d& uv(int v) const { return uv_[v]; }
  const Eigen::Vector3f& position(int v) const { return samples_[v].position; }
  const Eigen::Vector3f& normal(int v) const { return samples_[v].normal; }
  float attribute(int v, int k) const { return attributes_[static_cast<std::size_t>(v) * width_ + k]; }

  /// Operators since the list was cleared, in order, if recording is on (it is at first).
  const std::vector<StellarChange>& changes() const { return changes_; }
  void clear_changes() { changes_.clear(); }
  void set_recording(bool is_on) { is_recording_ = is_on; }

  /// Vertices and faces in the order of their slots, free ones left out; with normals and (u,v).
  TriangleMesh to_triangle_mesh() const;
  /// Broken invariants: those of the triangulation, faces turned over in (u,v), numbers that are not finite.
  std::vector<std::string> validate() const;
  std::size_t memory_bytes() const;  ///< without the list of changes

 private:
  struct OrderedQueue;
  void apply(const StellarChange& change);
  void take_sample(const StellarChange& change);
  int refine_chain(int face);
  int simplify_chain(int vertex);
  bool may_go_on(const AdaptBudget& budget, int& requests) const;
  void add_onlookers(std::size_t first_new);
  int exchange(double limit);
  void spend(const AdaptBudget& budget, OrderedQueue& queue, AdaptReport& report);

  AdaptiveSurface& surface_;
  MultiTriangulation triangulation_;
  std::vector<Eigen::Vector2d> uv_;
  std::vector<VertexSample> samples_;
  int width_ = 0;
  std::vector<float> attributes_;
  std::vector<StellarChange> changes_;
  std::vector<int> pending_;  ///< faces that came to be during a refinement
  bool is_recording_ = true;
};

}  // namespace phiz
