/// Triangles with fields on points and cells for ParaView: VTK's unstructured grid in XML, `.vtu`.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gradus/mesh/tri_mesh.hpp"

namespace gradus {

/// Values at the points or cells of a mesh. The data is not copied.
struct VtuField {
    std::string name;
    int components = 1;  ///< numbers per point or cell, >= 1
    std::span<const double>
        data;  ///< components of the first, of the second ...; not-a-number and infinity are allowed
};

/// Writes the data as appended raw binary, in double precision.
/// @throws std::invalid_argument naming the field whose length is not components times the number of points or cells,
/// whose
///         name is empty or given twice, and for a triangle with an index out of range
/// @throws IoError if the file cannot be written
void write_vtu(const std::string& path, std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles,
               const std::vector<VtuField>& point_fields = {}, const std::vector<VtuField>& cell_fields = {});

}  // namespace gradus
