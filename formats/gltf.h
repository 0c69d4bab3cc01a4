#pragma once

#include <iosfwd>
#include <vector>

#include "formats/triangle_mesh.h"

namespace phiz {

/// A .glb that any program shows: one node, one mesh, nothing compressed, vertex and triangle order kept.
/// The mesh is in mm, +y up, +z forward; its node scales by 0.001 to glTF's metres. Normals are made unit (a
/// zero normal becomes +y), uv become v downwards, colours linear 16-bit. Without triangles the vertices are
/// points. Same mesh, same bytes. Throws FormatError: what check_mesh refuses, no vertices, above 4 GiB. O(V
/// + F).
void write_glb(const TriangleMesh& mesh, std::ostream& out);

/// A .glb of one head in several levels, finest first: the scene's node shows the first, `MSFT_lod` names the
/// others, with shares of the screen from which each is wanted. Throws as write_glb does.
void write_lod_glb(const std::vector<TriangleMesh>& meshes, std::ostream& out);

/// A .drc (sequential Draco, vertex and triangle order kept) in the mesh's own unit: positions in 16 bits of
/// its longest side, normals in 10, uv in 14, colours exact. Throws FormatError as above, or without
/// triangles.
void write_drc(const TriangleMesh& mesh, std::ostream& out);

}  // namespace phiz
