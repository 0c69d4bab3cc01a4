#pragma once

#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace phiz::test {

/// Small meshes with known properties; positions and triangles only. Triangles are counter-clockwise seen
/// from outside (from +z for flat ones), every edge has at most two triangles, directed edges are unique.

TriangleMesh single_triangle();     ///< one right triangle in z = 0
TriangleMesh tetrahedron();         ///< regular, vertices on the unit sphere
TriangleMesh icosphere(int level);  ///< unit sphere, 10 * 4^level + 2 vertices; level 0 is the icosahedron
TriangleMesh open_grid(int columns, int rows);  ///< [0,1]^2 in z = 0; columns x rows cells, 2 triangles each
TriangleMesh disk(int sectors, int rings);   ///< unit disk in z = 0; the centre has valence `sectors` (>= 3)
TriangleMesh torus(int around, int across);  ///< radii 1 (about z) and 0.4, every vertex has valence 6
TriangleMesh sliver_mesh();                  ///< a strip with needles, caps and two triangles of zero area

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};

/// One of each, small: what a mesh algorithm should survive.
std::vector<NamedMesh> mesh_zoo();

}  // namespace phiz::test
