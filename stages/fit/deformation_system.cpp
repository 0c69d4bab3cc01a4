#include "stages/fit/deformation_system.h"

#include "stages/geometry/error.h"

namespace phiz {

DeformationSystem::DeformationSystem(const StencilMatrix& samples, const StencilMatrix& laplacian)
    : samples_(samples),
      laplacian_(laplacian),
      samples_transposed_(samples.transpose()),
      laplacian_transposed_(laplacian.transpose()) {}

double DeformationSystem::energy(const Positions& x) const {
  const Positions p = samples_ * x;
  double energy = 0;
  for (std::size_t i = 0; i < sample_terms.size(); ++i) {
    const SampleTerm& t = sample_terms[i];
    const Eigen::Vector3d at = p.row(i).transpose();
    energy += t.weight * std::pow(t.normal.dot(at - t.target), 2) +
              t.point_weight * (at - t.slide_target).squaredNorm();
  }
  const Positions bend = laplacian_ * x - delta;
  energy += (smooth_weights.array() * bend.rowwise().squaredNorm().array()).sum();
  for (const PairTerm& t : pair_terms)
    energy += t.weight * (x.row(t.a) - x.row(t.b) - t.difference.transpose()).squaredNorm();
  for (const PlaneTerm& t : plane_terms)
    energy += t.weight * std::pow(t.normal.dot(x.row(t.vertex_idx).transpose()) - t.offset, 2);
  return energy;
}

DeformationSystem::Positions DeformationSystem::gradient(const Positions& x, bool homogeneous) const {
  Positions at_samples = samples_ * x;
  for (std::size_t i = 0; i < sample_terms.size(); ++i) {
    const SampleTerm& t = sample_terms[i];
    const Eigen::Vector3d at = at_samples.row(i).transpose();
    const Eigen::Vector3d from_target = homogeneous ? at : at - t.target;
    const Eigen::Vector3d from_slide = homogeneous ? at : at - t.slide_target;
    at_samples.row(i) =
        (t.weight * t.normal.dot(from_target) * t.normal + t.point_weight * from_slide).transpose();
  }
  Positions bend = laplacian_ * x;
  if (!homogeneous) bend -= delta;
  bend = smooth_weights.asDiagonal() * bend;
  Positions g = samples_transposed_ * at_samples;
  g += laplacian_transposed_ * bend;
  for (const PairTerm& t : pair_terms) {
    Eigen::RowVector3d d = x.row(t.a) - x.row(t.b);
    if (!homogeneous) d -= t.difference.transpose();
    g.row(t.a) += t.weight * d;
    g.row(t.b) -= t.weight * d;
  }
  for (const PlaneTerm& t : plane_terms) {
    const double d = t.normal.dot(x.row(t.vertex_idx).transpose()) - (homogeneous ? 0.0 : t.offset);
    g.row(t.vertex_idx) += t.weight * d * t.normal.transpose();
  }
  return g;
}

int DeformationSystem::solve(Positions& x, double reduction, int max_iterations) const {
  CONTRACT(static_cast<Eigen::Index>(sample_terms.size()) == samples_.rows());
  // Isotropic part: a plane term counts a third in every direction; the samples' products are lumped.
  Eigen::VectorXd lumped(samples_.rows());
  for (Eigen::Index i = 0; i < samples_.rows(); ++i)
    lumped[i] = sample_terms[i].weight / 3 + sample_terms[i].point_weight;
  Eigen::VectorXd diagonal = samples_transposed_.cwiseAbs() * lumped;
  for (const PairTerm& t : pair_terms) diagonal[t.a] += t.weight, diagonal[t.b] += t.weight;
  for (const PlaneTerm& t : plane_terms) diagonal[t.vertex_idx] += t.weight / 3;
  diagonal.array() += 1e-6 * (1.0 + diagonal.maxCoeff());
  Eigen::SparseMatrix<double> isotropic = laplacian_transposed_ * smooth_weights.asDiagonal() * laplacian_;
  isotropic.diagonal() += diagonal;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> preconditioner(isotropic);
  if (preconditioner.info() != Eigen::Success) throw NumericalFailure("the fit's system is singular");

  Positions residual = -gradient(x, false);
  const double target = reduction * reduction * residual.squaredNorm();
  Positions z = preconditioner.solve(residual), direction = z;
  double rho = residual.cwiseProduct(z).sum();
  for (int k = 1; k <= max_iterations; ++k) {
    if (!(rho > 0)) return k - 1;
    const Positions q = gradient(direction, true);
    const double alpha = rho / direction.cwiseProduct(q).sum();
    x += alpha * direction;
    residual -= alpha * q;
    if (residual.squaredNorm() <= target) return k;
    z = preconditioner.solve(residual);
    const double next = residual.cwiseProduct(z).sum();
    direction = z + (next / rho) * direction;
    rho = next;
  }
  return max_iterations;
}

}  // namespace phiz
