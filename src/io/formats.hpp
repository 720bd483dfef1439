/// The formats behind mesh_files.hpp: from the bytes of a file to a soup and back. `path` is for messages.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gradus/control/tensor.hpp"
#include "gradus/mesh/soup.hpp"
#include "gradus/plane/planar_graph.hpp"
#include "gradus/surface/subdivision.hpp"

namespace gradus::io {

/// In lower case, with the dot.
std::string extension_of(const std::string& path);

/// @throws std::invalid_argument naming the function if the soup is what no file may hold, since no reader would take
/// it
void check_writable(const char* function, const TriangleSoup& soup);
/// The same for fields: names given once, and as many values as there are things.
void check_writable(const char* function, const std::vector<Field>& fields, std::size_t count, const char* where);

/// Labels that are all zero are none.
void drop_if_zero(std::vector<int>& labels);

/// Whether fields are wanted, besides the soup.
enum class Fields { Skipped, Read };

MeshData parse_msh(const std::string& path, std::string_view contents, Fields fields);
MeshData parse_ply(const std::string& path, std::string_view contents, Fields fields);
MeshData parse_vtk_xml(const std::string& path, std::string_view contents, Fields fields);
TriangleSoup parse_medit(const std::string& path, std::string_view text);
TriangleSoup parse_medit_binary(const std::string& path, std::string_view bytes);
Cage parse_cage(const std::string& path, std::string_view text);
TriangleSoup parse_obj(const std::string& path, std::string_view text);
TriangleSoup parse_poly(const std::string& path, std::string_view text);
/// A planar domain as triangles. @throws IoError for what is wrong with it
TriangleSoup triangulated(const std::string& path, const PlanarGraph& graph);
TriangleSoup parse_off(const std::string& path, std::string_view text);
TriangleSoup parse_stl(const std::string& path, std::string_view contents);
std::vector<double> parse_sol(const std::string& path, std::string_view text,
                              std::optional<std::size_t> expected_count);
/// Without names.
std::vector<Field> parse_solution(const std::string& path, std::string_view text,
                                  std::optional<std::size_t> expected_count);
std::vector<Field> parse_solution_binary(const std::string& path, std::string_view bytes,
                                         std::optional<std::size_t> expected_count);
std::vector<double> parse_sol_binary(const std::string& path, std::string_view bytes,
                                     std::optional<std::size_t> expected_count);

// The soups have been checked: finite coordinates, indices in range.
std::string medit_text(const TriangleSoup& soup);
std::string medit_binary(const TriangleSoup& soup);
std::string msh_text(const TriangleSoup& soup);
/// With its fields; those of components beyond kMostComponents have been refused.
std::string msh_text(const MeshData& data);
inline constexpr int kMostComponents = 64;
/// A section to append: one value per vertex.
std::string msh_node_data(std::string_view name, std::span<const double> values);
std::string obj_text(const TriangleSoup& soup);
std::string off_text(const TriangleSoup& soup);
std::string ply_text(const MeshData& data);
std::string ply_binary(const MeshData& data);
std::string stl_text(const TriangleSoup& soup);
/// @throws std::invalid_argument if a coordinate is beyond single precision
std::string stl_binary(const TriangleSoup& soup);
/// Edges are cells behind the triangles.
std::string vtu_binary(const MeshData& data);
inline constexpr std::string_view kLabelField = "label";  ///< in which .vtu and .ply keep the labels
/// The fields of cells to write: without one of labels where the soup has them.
std::vector<Field> cell_fields_of(const MeshData& data);
/// Whether a field is of integers, and all its values are some that a double has exactly.
bool holds_integers(const Field& field);
/// @param dimension  of the mesh they are for, 2 or 3
std::vector<Tensor> parse_metrics(const std::string& path, std::string_view text,
                                  std::optional<std::size_t> expected_count);
std::vector<Tensor> parse_metrics_binary(const std::string& path, std::string_view bytes,
                                         std::optional<std::size_t> expected_count);
/// @param components  per vertex: 1, else those of a symmetric matrix
std::string sol_text(std::span<const double> values, int components, int dimension);
std::string sol_binary(std::span<const double> values, int components, int dimension);

}  // namespace gradus::io
