#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <string>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// The authored source of a generic head: points and feature curves in the right half (u <= 1/2) of the (u,v)
/// square; the left half is its mirror image. Text, one statement a line, `#` starts a comment:
///
///   point NAME U V                      a point with a name
///   free [NAME] U V                     a point that may move along the surface
///   curve NAME [closed] P...            edges from point to point; a spline through them is followed by the
///   split
///                                       mesh and its points stay where they are. `P!` is a corner of the
///                                       spline
///   flow NAME [closed] P...             edges from point to point; its points may move
///   edge P Q                            an edge that is not flipped: where the flow is to be another than
///   found region RIGHT [LEFT] at U V... within CURVE...   flooded from (U,V) up to the curves; LEFT names
///   the mirror image
///                                       (without it the region is both); `also REGION...` adds whole regions
///   landmark RIGHT [LEFT] U V
///   box RIGHT [LEFT] REGION PAD_MM      bounding box of a region
///   bind P Q                            these two are held together by the fit
///   constrain REGION or CURVE           its vertices are held by their surroundings, not by the scan
///   plane NAME NY NZ OFFSET_MM          clipping plane; `neck` cuts the reference
///   scale S X Y Z R0 R1                 (u,v) size sought near (X,Y,Z) mm of the reference, fading from R0
///   to R1
/// Points with u = 1/2 lie on the mirror line, those with u = 0, v = 0 or v = 1 on the neck loop.
struct Layout {
  struct Point {
    std::string name;  ///< may be empty
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
    bool held = false;  ///< on a `curve`
    int line = 0;       ///< of the text, from 1; also below
  };
  struct Curve {
    std::string name;
    bool closed = false, held = true;
    std::vector<int> points;
    std::vector<bool> corner;  ///< per point
    int line = 0;
  };
  struct Region {
    std::string right, left;  ///< equal where the region is on both sides
    std::vector<Eigen::Vector2d> seeds;
    std::vector<int> walls;              ///< curves
    std::vector<std::string> including;  ///< earlier regions
    int line = 0;
  };
  struct Landmark {
    std::string right, left;  ///< equal on the mirror line
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
    int line = 0;
  };
  struct Box {
    std::string right, left, region;
    double pad_mm = 0;
    int line = 0;
  };
  struct Scale {
    double scale = 1;
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double inner_mm = 0, outer_mm = 0;
  };

  std::vector<Point> points;
  std::vector<Curve> curves;
  std::vector<Region> regions;
  std::vector<Landmark> landmarks;
  std::vector<Box> boxes;
  std::vector<std::pair<int, int>> edges;     ///< points
  std::vector<std::pair<int, int>> bindings;  ///< points
  std::vector<std::string> constrained_regions, constrained_curves;
  std::map<std::string, Plane> planes;
  std::vector<Scale> scales;
};

/// Reads a layout. Throws FormatError with the line: unknown statements, unknown or repeated names, numbers
/// that are none, points outside the half square, two points in one place, curves that touch a point twice.
Layout parse_layout(std::istream& in);

}  // namespace phiz
