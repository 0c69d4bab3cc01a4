#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

namespace phiz {

/// Principal components of vectors that come one after the other (shapes over the (u,v) square, three numbers
/// a node). Vectors are kept as float, sums are double. Memory: components + 2 + batch vectors, however many
/// come. Exact (to float) as long as no more than `components` directions are needed; beyond, the smallest
/// are cut off at every update. Deterministic at any thread count; depends on the order of the vectors by
/// rounding and by what was cut off. Source: Ross, Lim, Lin, Yang 2008 (incremental PCA with a moving mean);
/// small problems by their Gram matrix.
class StreamingPca {
 public:
  /// `weights` of the entries (mm^2 a node, three times each): inner products are sums of weight x y. > 0.
  /// components 1 .. 1000.
  StreamingPca(std::vector<float> weights, int components);

  /// Throws InvalidInput where the length differs or a number is not finite.
  void add(std::span<const float> vector);
  /// Takes in what waits for a full batch. Called by add(); call it once after the last vector.
  void finish();

  /// All that add() has come to, so that an interrupted computation can continue: bytes of this machine's
  /// layout.
  std::string encode() const;
  /// False, and nothing changed, where the bytes are not of the same weights and number of components.
  bool restore(std::string_view bytes);

  std::size_t count() const { return count_ + batch_.size(); }
  std::size_t length() const { return weights_.size(); }
  const std::vector<float>& weights() const { return weights_; }

  // After finish():
  const std::vector<double>& mean() const { return mean_; }
  int component_count() const { return static_cast<int>(variances_.size()); }
  /// Unit length in the weighted inner product, orthogonal, in order of falling variance; the entry of
  /// largest size is positive.
  const std::vector<float>& component(int index) const { return components_[index]; }
  const std::vector<double>& variances() const { return variances_; }  ///< along each, over count - 1
  double total_variance() const;  ///< of all that was added, cut off or not

 private:
  void update();

  std::vector<float> weights_;
  int most_;
  std::size_t count_ = 0;
  std::vector<std::vector<float>> batch_;
  std::vector<double> mean_;
  std::vector<std::vector<float>> components_;
  std::vector<double> variances_;
  double scatter_ = 0;  ///< sum of squared weighted distances to the mean
};

/// A finished model.
struct ShapeModel {
  std::vector<float> weights, mean;
  std::vector<std::vector<float>> components;
  std::vector<double> variances;
  double total_variance = 0;
};
ShapeModel make_shape_model(const StreamingPca& pca);

/// Coefficients (mm times the root of the weights' sum) of a vector: orthogonal projection on the first
/// `components`, all if negative.
std::vector<double> project(const ShapeModel& model, std::span<const float> vector, int components = -1);
/// mean + sum of coefficient times component. Missing coefficients are 0.
std::vector<float> synthesise(const ShapeModel& model, std::span<const double> coefficients);
/// Coefficients from the entries that are known alone: least squares with the model's variances as prior,
/// `noise` mm being the standard deviation of an entry. All known and noise 0: the projection. Throws
/// InvalidInput where nothing is known.
std::vector<double> reconstruct(const ShapeModel& model, std::span<const float> vector,
                                const std::vector<bool>& is_known, double noise_mm);

/// The rigid motion (no scale) that brings `from` nearest to `to` in least squares (Kabsch).
Eigen::Isometry3d find_rigid_alignment(std::span<const Eigen::Vector3d> from,
                                       std::span<const Eigen::Vector3d> to);

}  // namespace phiz
