#include "stages/deform/pca.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr std::size_t kBatch = 16;
constexpr std::size_t kGrain = 16384;
constexpr double kLeastShare = 1e-10;  ///< of the largest eigenvalue: smaller ones are rounding

double dot(std::span<const float> weights, std::span<const float> a, std::span<const float> b) {
  return parallel_sum(weights.size(), kGrain, 0.0, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += double{weights[i]} * a[i] * b[i];
    return sum;
  });
}

/// Takes `a`'s share out of `b`.
void subtract_share(std::span<const float> weights, std::span<const float> a, std::span<float> b) {
  const double share = dot(weights, a, b);
  parallel_for(b.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) b[i] = static_cast<float>(b[i] - share * a[i]);
  });
}

void normalise(std::span<const float> weights, std::vector<float>& vector) {
  const double length = std::sqrt(dot(weights, vector, vector));
  if (!(length > 0)) return;
  const auto largest = std::max_element(vector.begin(), vector.end(),
                                        [](float a, float b) { return std::abs(a) < std::abs(b); });
  const double factor = (*largest < 0 ? -1 : 1) / length;
  for (float& value : vector) value = static_cast<float>(factor * value);
}

}  // namespace

StreamingPca::StreamingPca(std::vector<float> weights, int components)
    : weights_(std::move(weights)), most_(components) {
  if (components < 1 || components > 1000) throw InvalidInput("1 to 1000 components can be kept");
  const bool is_positive =
      std::all_of(weights_.begin(), weights_.end(), [](float w) { return std::isfinite(w) && w > 0; });
  if (weights_.empty() || !is_positive) throw InvalidInput("weights must be above 0");
  mean_.assign(weights_.size(), 0.0);
}

void StreamingPca::add(std::span<const float> vector) {
  if (vector.size() != weights_.size()) throw InvalidInput("a shape has another number of nodes");
  if (!std::all_of(vector.begin(), vector.end(), [](float v) { return std::isfinite(v); }))
    throw InvalidInput("a shape is not finite");
  batch_.emplace_back(vector.begin(), vector.end());
  if (batch_.size() >= kBatch) update();
}

void StreamingPca::finish() {
  if (!batch_.empty()) update();
}

namespace {

struct StateHeader {
  std::uint64_t tag = 0x3161637067697a70;  // changes whenever the layout does
  std::uint64_t length = 0, most = 0, count = 0, batch = 0, components = 0;
  double scatter = 0;
};

template <class Number>
void append(std::string& bytes, const std::vector<Number>& numbers) {
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
}

/// `bytes` must hold so many.
template <class Number>
std::vector<Number> take(std::string_view& bytes, std::size_t count) {
  std::vector<Number> numbers(count);
  if (count > 0) std::memcpy(numbers.data(), bytes.data(), count * sizeof(Number));
  bytes.remove_prefix(count * sizeof(Number));
  return numbers;
}

}  // namespace

std::string StreamingPca::encode() const {
  StateHeader header;
  header.length = weights_.size();
  header.most = static_cast<std::uint64_t>(most_);
  header.count = count_;
  header.batch = batch_.size();
  header.components = components_.size();
  header.scatter = scatter_;
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  append(bytes, weights_);
  append(bytes, mean_);
  append(bytes, variances_);
  for (const std::vector<float>& component : components_) append(bytes, component);
  for (const std::vector<float>& vector : batch_) append(bytes, vector);
  return bytes;
}

bool StreamingPca::restore(std::string_view bytes) {
  StateHeader header;
  if (bytes.size() < sizeof header) return false;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  const std::uint64_t rows = header.components + header.batch, length = weights_.size();
  const bool is_ours = header.tag == StateHeader{}.tag && header.length == length &&
                       header.most == static_cast<std::uint64_t>(most_) && header.components <= header.most &&
                       header.batch <= bytes.size() / sizeof(float) / length;
  const std::uint64_t expected = length * (sizeof(float) + sizeof(double)) +
                                 header.components * sizeof(double) + rows * length * sizeof(float);
  if (!is_ours || bytes.size() != expected) return false;
  if (take<float>(bytes, length) != weights_) return false;
  mean_ = take<double>(bytes, length);
  variances_ = take<double>(bytes, header.components);
  components_.clear();
  batch_.clear();
  for (std::uint64_t i = 0; i < header.components; ++i) components_.push_back(take<float>(bytes, length));
  for (std::uint64_t i = 0; i < header.batch; ++i) batch_.push_back(take<float>(bytes, length));
  count_ = header.count;
  scatter_ = header.scatter;
  return true;
}

double StreamingPca::total_variance() const {
  return count_ > 1 ? scatter_ / static_cast<double>(count_ - 1) : 0;
}

/// The new components are those of: the old ones times their spread, the batch about its own mean, and the
/// way between the means.
void StreamingPca::update() {
  const double old_count = static_cast<double>(count_), batch_count = static_cast<double>(batch_.size());
  const double between = std::sqrt(old_count * batch_count / (old_count + batch_count));
  std::vector<std::vector<float>> rows;
  for (std::size_t k = 0; k < components_.size(); ++k) {
    const double spread = std::sqrt(variances_[k] * std::max(0.0, old_count - 1));
    for (float& value : components_[k]) value = static_cast<float>(spread * value);
    rows.push_back(std::move(components_[k]));
  }
  const std::size_t old_rows = rows.size();
  for (std::vector<float>& vector : batch_) rows.push_back(std::move(vector));
  std::vector<float> way(length());
  parallel_for(length(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double mean = 0;
      for (std::size_t r = old_rows; r < rows.size(); ++r) mean += rows[r][i];
      mean /= batch_count;
      for (std::size_t r = old_rows; r < rows.size(); ++r) rows[r][i] = static_cast<float>(rows[r][i] - mean);
      way[i] = static_cast<float>(between * (mean - mean_[i]));
      mean_[i] += (mean - mean_[i]) * batch_count / (old_count + batch_count);
    }
  });
  if (count_ > 0) rows.push_back(std::move(way));
  count_ += batch_.size();
  batch_.clear();

  const auto size = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd gram(size, size);
  for (Eigen::Index a = 0; a < size; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) gram(a, b) = gram(b, a) = dot(weights_, rows[a], rows[b]);
  for (Eigen::Index a = static_cast<Eigen::Index>(old_rows); a < size; ++a) scatter_ += gram(a, a);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  const Eigen::VectorXd& values = solver.eigenvalues();  // ascending
  components_.clear();
  variances_.clear();
  const double divisor = std::max(1.0, static_cast<double>(count_ - 1));
  for (Eigen::Index k = size - 1; k >= 0 && static_cast<int>(components_.size()) < most_; --k) {
    if (!(values[k] > kLeastShare * values[size - 1])) break;
    std::vector<float> component(length());
    parallel_for(length(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        double sum = 0;
        for (Eigen::Index r = 0; r < size; ++r) sum += solver.eigenvectors()(r, k) * rows[r][i];
        component[i] = static_cast<float>(sum);
      }
    });
    normalise(weights_, component);
    for (const std::vector<float>& before : components_) subtract_share(weights_, before, component);
    normalise(weights_, component);
    components_.push_back(std::move(component));
    variances_.push_back(values[k] / divisor);
  }
}

ShapeModel make_shape_model(const StreamingPca& pca) {
  ShapeModel model;
  model.weights = pca.weights();
  model.mean.assign(pca.mean().begin(), pca.mean().end());
  for (int k = 0; k < pca.component_count(); ++k) model.components.push_back(pca.component(k));
  model.variances = pca.variances();
  model.total_variance = pca.total_variance();
  return model;
}

std::vector<double> project(const ShapeModel& model, std::span<const float> vector, int components) {
  if (vector.size() != model.mean.size())
    throw InvalidInput("the shape has another number of nodes than the model");
  std::vector<float> about_mean(vector.size());
  for (std::size_t i = 0; i < vector.size(); ++i) about_mean[i] = vector[i] - model.mean[i];
  const std::size_t count =
      components < 0 ? model.components.size() : std::min<std::size_t>(components, model.components.size());
  std::vector<double> coefficients;
  for (std::size_t k = 0; k < count; ++k)
    coefficients.push_back(dot(model.weights, model.components[k], about_mean));
  return coefficients;
}

std::vector<float> synthesise(const ShapeModel& model, std::span<const double> coefficients) {
  if (coefficients.size() > model.components.size())
    throw InvalidInput("the model has " + std::to_string(model.components.size()) + " components, not " +
                       std::to_string(coefficients.size()));
  std::vector<float> vector(model.mean.size());
  parallel_for(vector.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = model.mean[i];
      for (std::size_t k = 0; k < coefficients.size(); ++k) sum += coefficients[k] * model.components[k][i];
      vector[i] = static_cast<float>(sum);
    }
  });
  return vector;
}

std::vector<double> reconstruct(const ShapeModel& model, std::span<const float> vector,
                                const std::vector<bool>& is_known, double noise_mm) {
  if (vector.size() != model.mean.size() || is_known.size() != vector.size())
    throw InvalidInput("the shape has another number of nodes than the model");
  std::vector<float> weights = model.weights, about_mean(vector.size(), 0.0f);
  double known = 0;
  for (std::size_t i = 0; i < vector.size(); ++i) {
    if (is_known[i]) about_mean[i] = vector[i] - model.mean[i];
    if (!is_known[i]) weights[i] = 0;
    known += is_known[i];
  }
  if (known == 0) throw InvalidInput("nothing of the shape is known");
  const auto count = static_cast<Eigen::Index>(model.components.size());
  Eigen::MatrixXd gram(count, count);
  Eigen::VectorXd right(count);
  for (Eigen::Index a = 0; a < count; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b)
      gram(a, b) = gram(b, a) = dot(weights, model.components[a], model.components[b]);
    right[a] = dot(weights, model.components[a], about_mean);
    gram(a, a) += noise_mm * noise_mm / std::max(1e-12, model.variances[a]);
  }
  const Eigen::VectorXd solution = gram.completeOrthogonalDecomposition().solve(right);
  return {solution.data(), solution.data() + count};
}

Eigen::Isometry3d find_rigid_alignment(std::span<const Eigen::Vector3d> from,
                                       std::span<const Eigen::Vector3d> to) {
  CONTRACT(from.size() == to.size() && !from.empty());
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = from_mean;
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i];
    to_mean += to[i];
  }
  from_mean /= static_cast<double>(from.size());
  to_mean /= static_cast<double>(from.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool flips = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() =
      svd.matrixU() * Eigen::Vector3d(1, 1, flips ? -1 : 1).asDiagonal() * svd.matrixV().transpose();
  motion.translation() = to_mean - motion.linear() * from_mean;
  return motion;
}

}  // namespace phiz
