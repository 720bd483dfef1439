/// Fields of a triangulation on their way to its mesh.
#pragma once

#include <string>
#include <vector>

#include "gradus/control/triangulation.hpp"
#include "gradus/remesh/surface_mesh.hpp"
#include "json.hpp"

namespace gradus::app {

struct Fields {
    std::vector<Field> points, cells;
    std::vector<std::string> own;  ///< names of those left behind, as a mesh has fields of these names of its own

    std::size_t size() const { return points.size() + cells.size(); }
};

/// Those of the file of a triangulation, aligned with what load_triangulation makes of it, and those of solutions at
/// its vertices.
/// @throws UsageError for a solution of another extension; IoError; Failure for two fields of one name
Fields load_fields(const std::string& path, bool repair, const std::vector<std::string>& solutions);

/// On a mesh of the triangulation; nothing if no output can hold any.
Fields carry(const Triangulation& surface, const Fields& fields, const SurfaceMesh& mesh,
             const std::vector<std::string>& outputs);

/// "T, velocity (3)"
std::string names_of(const std::vector<Field>& fields);
Json json_of(const std::vector<Field>& fields);

/// What is carried where, and what cannot be: a line for each. @param fields  of the input
std::string text_of(const Fields& fields, const std::vector<std::string>& outputs);
Json json_of(const Fields& fields, const std::vector<std::string>& outputs);

}  // namespace gradus::app
