/// The formats behind mesh_files.hpp: from the bytes of a file to a soup and back. `path` is for messages.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus::io {

/// In lower case, with the dot.
std::string extension_of(const std::string& path);

/// @throws std::invalid_argument naming the function if the soup is what no file may hold, since no reader would take it
void check_writable(const char* function, const TriangleSoup& soup);

/// Whether fields are wanted, besides the soup.
enum class Fields { Skipped, Read };

MeshData parse_msh(const std::string& path, std::string_view contents, Fields fields);
MeshData parse_ply(const std::string& path, std::string_view contents, Fields fields);
MeshData parse_vtk_xml(const std::string& path, std::string_view contents, Fields fields);
TriangleSoup parse_medit(const std::string& path, std::string_view text);
TriangleSoup parse_medit_binary(const std::string& path, std::string_view bytes);
TriangleSoup parse_obj(const std::string& path, std::string_view text);
TriangleSoup parse_off(const std::string& path, std::string_view text);
TriangleSoup parse_stl(const std::string& path, std::string_view contents);
std::vector<double> parse_sol(const std::string& path, std::string_view text, std::optional<std::size_t> expected_count);
std::vector<double> parse_sol_binary(const std::string& path, std::string_view bytes, std::optional<std::size_t> expected_count);

// The soups have been checked: finite coordinates, indices in range.
std::string medit_text(const TriangleSoup& soup);
std::string medit_binary(const TriangleSoup& soup);
std::string msh_text(const TriangleSoup& soup);
/// A section to append: one value per vertex.
std::string msh_node_data(std::string_view name, std::span<const double> values);
std::string obj_text(const TriangleSoup& soup);
std::string off_text(const TriangleSoup& soup);
std::string ply_text(const TriangleSoup& soup);
std::string ply_binary(const TriangleSoup& soup);
std::string stl_text(const TriangleSoup& soup);
/// @throws std::invalid_argument if a coordinate is beyond single precision
std::string stl_binary(const TriangleSoup& soup);
/// Edges are cells behind the triangles.
std::string vtu_binary(const TriangleSoup& soup);
inline constexpr std::string_view kLabelField = "label";  ///< in which .vtu keeps the labels
std::string sol_text(std::span<const double> sizes);
std::string sol_binary(std::span<const double> sizes);

}  // namespace gradus::io
