#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/scan_file.h"

namespace phiz::test {

/// A small head-sized cloud with everything a file may hold, and triangles.
struct ScanSample {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint8_t, 3>> colours;
  std::vector<float> confidences;
  std::vector<Eigen::Vector3i> triangles;
};

/// A bumpy sphere of about 100 mm with 42 vertices and 80 triangles; the tests' generator gives the bumps.
ScanSample make_sample();

ScanFile parse(const std::string& bytes, const std::string& extension = "", const ScanLimits& limits = {});

/// What the parser says against these bytes: "what | hint"; "" if it reads them.
std::string fault_of(const std::string& bytes, const std::string& extension = "",
                     const ScanLimits& limits = {});

/// True positions: origin added.
std::vector<Eigen::Vector3d> true_positions(const ScanFile& scan);

/// The shortest text that reads back as the same float.
std::string text_of(float value);

// The sample in each format, as simply as the format allows.

enum class PlyKind { ascii, little, big };
/// One property of the vertices: its name, a PLY type, a value for each vertex.
struct PlyColumn {
  std::string name, type;
  std::vector<double> values;
};
/// `list_at` >= 0 puts a list of changing length in front of that column. Triangles follow if there are any.
std::string write_ply_as(PlyKind kind, const std::vector<PlyColumn>& columns,
                         const std::vector<Eigen::Vector3i>& triangles, int list_at = -1);
std::vector<PlyColumn> ply_columns(const ScanSample& sample);
/// Bytes of one number in a PLY type.
std::string ply_number(PlyKind kind, const std::string& type, double value);

std::string write_obj_text(const ScanSample& sample);  ///< with colours and normals
std::string write_stl_text(const ScanSample& sample);
std::string write_stl_binary(const ScanSample& sample);
std::string write_off_text(const ScanSample& sample);  ///< CNOFF: normals and colours
std::string write_columns(const ScanSample& sample, const std::string& separator);  ///< x y z r g b nx ny nz
std::string write_drc(const ScanSample& sample, bool as_mesh);                      ///< lossless, order kept
/// A .glb from its JSON and binary chunks.
std::string glb_of(std::string json, std::string binary);
/// A mesh with positions, normals, colours (linear floats are not used: normalised bytes) and ushort indices.
std::string write_glb(const ScanSample& sample);
std::string write_draco_glb(const ScanSample& sample);

}  // namespace phiz::test
