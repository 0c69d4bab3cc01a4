#include "stages/align/silhouette_osmesa.h"

#include <GL/osmesa.h>

#include "stages/geometry/error.h"

namespace phiz {

struct OsmesaSilhouettes::Impl {
  OSMesaContext context = nullptr;
  int size = 0;
  std::vector<std::uint8_t> pixels;  ///< RGBA, bottom row first

  ~Impl() {
    if (context) OSMesaDestroyContext(context);
  }
  void begin();
  Silhouette read() const;
};

// Pixel coordinates with y down, as the frame gives them.
void OsmesaSilhouettes::Impl::begin() {
  if (!OSMesaMakeCurrent(context, pixels.data(), GL_UNSIGNED_BYTE, size, size))
    throw NumericalFailure("OSMesa context cannot be made current");
  glViewport(0, 0, size, size);
  glMatrixMode(GL_PROJECTION);
  glLoadIdentity();
  glOrtho(0, size, size, 0, -1, 1);
  glMatrixMode(GL_MODELVIEW);
  glLoadIdentity();
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_MULTISAMPLE);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glColor3f(1, 1, 1);
}

Silhouette OsmesaSilhouettes::Impl::read() const {
  glFinish();
  Silhouette out(size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      if (pixels[4 * (static_cast<std::size_t>(size - 1 - y) * size + x)] > 127) out.fill_span(y, x, x + 1);
  return out;
}

OsmesaSilhouettes::OsmesaSilhouettes(int size) : impl_(std::make_unique<Impl>()) {
  impl_->size = size;
  impl_->pixels.resize(4 * static_cast<std::size_t>(size) * size);
  impl_->context = OSMesaCreateContextExt(OSMESA_RGBA, 0, 0, 0, nullptr);
  if (!impl_->context) throw NumericalFailure("no OSMesa context");
}

OsmesaSilhouettes::~OsmesaSilhouettes() = default;
OsmesaSilhouettes::OsmesaSilhouettes(OsmesaSilhouettes&&) noexcept = default;
OsmesaSilhouettes& OsmesaSilhouettes::operator=(OsmesaSilhouettes&&) noexcept = default;

namespace {

std::vector<Eigen::Vector2d> project_all(std::span<const Eigen::Vector3f> positions,
                                         const AffineMatrix& frame_from_model, ViewAxis axis,
                                         const SilhouetteFrame& frame) {
  std::vector<Eigen::Vector2d> projected;
  projected.reserve(positions.size());
  for (const Eigen::Vector3f& p : positions)
    projected.push_back(frame.project(frame_from_model * p.cast<double>().homogeneous(), axis));
  return projected;
}

}  // namespace

Silhouette OsmesaSilhouettes::rasterise(std::span<const Eigen::Vector3f> positions,
                                        std::span<const Eigen::Vector3i> triangles,
                                        const AffineMatrix& frame_from_model, ViewAxis axis,
                                        const SilhouetteFrame& frame) {
  CONTRACT(frame.size == impl_->size);
  const std::vector<Eigen::Vector2d> projected = project_all(positions, frame_from_model, axis, frame);
  impl_->begin();
  glBegin(GL_TRIANGLES);
  for (const Eigen::Vector3i& t : triangles)
    for (const int corner : t) glVertex2dv(projected[static_cast<std::size_t>(corner)].data());
  glEnd();
  return impl_->read();
}

Silhouette OsmesaSilhouettes::rasterise_points(std::span<const Eigen::Vector3f> positions,
                                               const AffineMatrix& frame_from_model, ViewAxis axis,
                                               const SilhouetteFrame& frame, int size_px) {
  CONTRACT(frame.size == impl_->size);
  const std::vector<Eigen::Vector2d> projected = project_all(positions, frame_from_model, axis, frame);
  impl_->begin();
  glPointSize(static_cast<float>(size_px));
  glBegin(GL_POINTS);
  for (const Eigen::Vector2d& p : projected) glVertex2dv(p.data());
  glEnd();
  return impl_->read();
}

}  // namespace phiz
