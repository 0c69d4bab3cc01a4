#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace phiz {

/// What a field does to what it works on; a is its amount (gain times parameter), V its image at (u,v), m a
/// mask.
enum class FieldType {
  kConstant,  ///< p = V; without image: the subject's own neutral surface. Works on nothing
  kAdd,       ///< p = in + a V, V along the head's axes in mm
  kAddLocal,  ///< p = in + a F V, F the local frame of the subject's neutral surface at (u,v)
  kRotate,    ///< p = in turned by the angle a m (rad) about `axis` of the subject's neutral surface
  kBlend,     ///< p = first + a m (second - first)
};

enum class FieldInterpolation { kBilinear, kBicubic };  ///< bicubic: Catmull-Rom, both pass through the nodes

/// Vectors (3 channels) or a mask (1) over the (u,v) square, given at the nodes of the deformation's grid:
/// node (x, y) lies at u = x / (width - 1), v = 1 - y / (height - 1), so that the borders are exact and row 0
/// is on top. Only a window of the grid is kept; outside it is zero.
struct FieldImage {
  int channels = 3;
  int x = 0, y = 0, width = 0, height = 0;  ///< the window, in nodes of the grid; 0 x 0: zero everywhere
  std::vector<float> values;                ///< [(row * width + column) * channels + channel]
  bool empty() const { return values.empty(); }
};

/// A place of the neutral surface made of landmarks; weights sum to 1.
using LandmarkPoint = std::map<std::string, double>;

/// A line through two places; a positive angle turns right-handed about `from` -> `to`.
struct FieldAxis {
  LandmarkPoint from, to;
};

/// Makes a field as large as a subject's own measure: the amount is multiplied by the distance of two
/// landmarks on the neutral surface over `reference_mm` (theirs on the head the field was made for).
struct FieldScale {
  std::string from, to;  ///< landmarks; empty: no scale
  double reference_mm = 0;
};

/// One step of the cascade.
struct DeformationField {
  std::string name;  ///< [a-z][A-Za-z0-9_]*, at most 64
  FieldType type = FieldType::kAddLocal;
  std::vector<std::string> inputs;  ///< fields it works on: constant none, blend two, others one
  std::string parameter;            ///< empty: the amount is the gain
  double gain = 1;                  ///< amount for parameter 1
  FieldImage image;                 ///< vectors; a mask where the type has m
  FieldInterpolation interpolation = FieldInterpolation::kBilinear;
  FieldAxis axis;  ///< of kRotate
  FieldScale scale;
  std::string origin;  ///< one line for people: "designed: muscles/risorius.json", "captured: dev00"
};

/// A number that moves fields; 0 is neutral.
struct DeformationParameter {
  std::string name;                 ///< as field names
  double minimum = 0, maximum = 1;  ///< minimum <= 0 <= maximum
};

/// A name that motion files use (ARKit's "jawOpen"), and which parameters answer to it: each gets the sum of
/// weight times value over all controls.
struct RigControl {
  std::string name;
  std::vector<std::string> aliases;     ///< "JawOpen", "mouthSmile_L": the same control
  std::map<std::string, double> terms;  ///< parameter -> weight; empty: a known name that moves nothing
};

/// Deformation fields over the (u,v) square of one generic head: independent of the subject's shape and of
/// the resolution of its surface. Fields form a cascade (no loops) that ends in `output`.
struct Deformation {
  std::string template_digest;  ///< SHA-256 of the generic head whose (u,v) this is; may be empty
  int width = 0, height = 0;    ///< of the grid, 2 .. 8192
  std::vector<DeformationParameter> parameters;
  std::vector<DeformationField> fields;  ///< any order; canonical files keep it
  std::string output;                    ///< the field that is the result
  std::vector<RigControl> controls;
};

/// Throws FormatError that names the field, parameter or control: names missing, twice or not allowed, inputs
/// of the wrong number, a loop, a parameter or grid out of range, an image of the wrong channels or beyond
/// the grid, numbers that are not finite.
void check_deformation(const Deformation& deformation);

/// Indices of the fields that `output` needs, each after those it works on; ties as in `fields`. Throws
/// FormatError that names the loop or the missing field.
std::vector<int> compute_cascade_order(const Deformation& deformation);

/// The smallest window of a full grid of width x height nodes that keeps every value that is not zero.
FieldImage crop_field_image(int width, int height, int channels, const std::vector<float>& values);
/// The full grid again: width * height * channels values.
std::vector<float> expand_field_image(const FieldImage& image, int width, int height);

int field_channels(FieldType type);           ///< 3, or 1 where the type has a mask
const char* field_type_name(FieldType type);  ///< "constant", "add", "add_local", "rotate", "blend"

/// A JSON of everything but the images and an EXR with a layer a field: `<field>.X .Y .Z` or `<field>.V`.
/// README.md documents every key. Same deformation, same bytes, also after reading and writing. Throws
/// FormatError: what check_deformation refuses, unknown keys and types, layers that do not belong, an EXR of
/// another size or template. O(fields * nodes): 1 s to write and 0.3 s to read 52 fields at 512 x 512.
void write_deformation(const Deformation& deformation, std::ostream& json, std::ostream& exr);
Deformation read_deformation(std::istream& json, std::istream& exr);

/// Index of the control of that name or alias; -1: none. And the known name nearest to it, for a hint.
int find_control(const Deformation& deformation, const std::string& name);
std::string find_nearest_control(const Deformation& deformation, const std::string& name);

}  // namespace phiz
