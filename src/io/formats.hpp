/// The formats behind mesh_files.hpp: from the bytes of a file to a soup and back. `path` is for messages.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus::io {

TriangleSoup parse_medit(const std::string& path, std::string_view text);
TriangleSoup parse_medit_binary(const std::string& path, std::string_view bytes);
TriangleSoup parse_obj(const std::string& path, std::string_view text);
TriangleSoup parse_off(const std::string& path, std::string_view text);
TriangleSoup parse_ply(const std::string& path, std::string_view contents);
TriangleSoup parse_stl(const std::string& path, std::string_view contents);
std::vector<double> parse_sol(const std::string& path, std::string_view text, std::optional<std::size_t> expected_count);
std::vector<double> parse_sol_binary(const std::string& path, std::string_view bytes, std::optional<std::size_t> expected_count);

// The soups have been checked: finite coordinates, indices in range.
std::string medit_text(const TriangleSoup& soup);
std::string medit_binary(const TriangleSoup& soup);
std::string obj_text(const TriangleSoup& soup);
std::string off_text(const TriangleSoup& soup);
std::string ply_text(const TriangleSoup& soup);
std::string ply_binary(const TriangleSoup& soup);
std::string stl_text(const TriangleSoup& soup);
/// @throws std::invalid_argument if a coordinate is beyond single precision
std::string stl_binary(const TriangleSoup& soup);
std::string sol_text(std::span<const double> sizes);
std::string sol_binary(std::span<const double> sizes);

}  // namespace gradus::io
