#include "gradus/io/mesh_files.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "formats.hpp"
#include "gradus/io/error.hpp"
#include "gradus/io/input_file.hpp"
#include "gradus/io/output_file.hpp"

namespace gradus {
namespace {

template <TriangleSoup (*parse)(const std::string&, std::string_view)>
MeshData without_fields(const std::string& path, std::string_view contents, io::Fields) {
    return {parse(path, contents)};
}

template <std::string (*text)(const TriangleSoup&)>
std::string soup_only(const MeshData& data) {
    return text(data.soup);
}

struct MeshFormat {
    const char* extension;
    bool fields;
    MeshData (*parse)(const std::string& path, std::string_view contents, io::Fields fields);
    std::string (*text)(const MeshData&);
    std::string (*binary)(const MeshData&);
};

/// Those that are only read have no functions for writing.
constexpr MeshFormat kMeshFormats[] = {
    {".mesh", false, without_fields<io::parse_medit>, soup_only<io::medit_text>, soup_only<io::medit_text>},
    {".meshb", false, without_fields<io::parse_medit_binary>, soup_only<io::medit_binary>, soup_only<io::medit_binary>},
    {".msh", true, io::parse_msh, io::msh_text, io::msh_text},
    {".obj", false, without_fields<io::parse_obj>, soup_only<io::obj_text>, soup_only<io::obj_text>},
    {".off", false, without_fields<io::parse_off>, soup_only<io::off_text>, soup_only<io::off_text>},
    {".ply", true, io::parse_ply, io::ply_text, io::ply_binary},
    {".poly", false, without_fields<io::parse_poly>, nullptr, nullptr},
    {".stl", false, without_fields<io::parse_stl>, soup_only<io::stl_text>, soup_only<io::stl_binary>},
    {".vtu", true, io::parse_vtk_xml, io::vtu_binary, io::vtu_binary},
    {".vtp", true, io::parse_vtk_xml, nullptr, nullptr},
};

struct SizeFormat {
    const char* extension;
    std::vector<double> (*parse)(const std::string& path, std::string_view contents,
                                 std::optional<std::size_t> expected_count);
    std::vector<Field> (*parse_fields)(const std::string& path, std::string_view contents,
                                       std::optional<std::size_t> expected_count);
    std::vector<Tensor> (*parse_metrics)(const std::string& path, std::string_view contents,
                                         std::optional<std::size_t> expected_count);
    std::string (*contents)(std::span<const double>, int components, int dimension);
};

constexpr SizeFormat kSizeFormats[] = {
    {".sol", io::parse_sol, io::parse_solution, io::parse_metrics, io::sol_text},
    {".solb", io::parse_sol_binary, io::parse_solution_binary, io::parse_metrics_binary, io::sol_binary},
};

template <class Formats>
const auto& format_of(const std::string& path, const Formats& formats) {
    const std::string extension = io::extension_of(path);
    std::string known;
    for (const auto& format : formats) {
        if (extension == format.extension) return format;
        known += std::string(known.empty() ? "" : " ") + format.extension;
    }
    throw IoError(
        path, 0,
        (extension.empty() ? "has no extension" : "has the unknown extension " + extension) + "; known are " + known);
}

std::string read_filled_file(const std::string& path) {
    std::string contents = read_file(path);
    if (contents.empty()) throw IoError(path, 0, "is empty");
    return contents;
}

[[noreturn]] void refuse(const char* function, const std::string& what) {
    throw std::invalid_argument(std::string(function) + ": " + what);
}

void check_vertex(const char* function, int vertex, std::size_t num_points, const char* what, std::size_t entry) {
    if (vertex < 0 || static_cast<std::size_t>(vertex) >= num_points)
        refuse(function, std::string(what) + " " + std::to_string(entry) + " has vertex " + std::to_string(vertex) +
                             " of " + std::to_string(num_points));
}

}  // namespace

std::string io::extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

void io::check_writable(const char* function, const TriangleSoup& soup) {
    const std::size_t n = soup.points.size();
    for (std::size_t i = 0; i < n; ++i)
        if (!soup.points[i].allFinite())
            refuse(function, "vertex " + std::to_string(i) + " has a coordinate that is not finite");
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
        for (const int vertex : soup.triangles[t]) check_vertex(function, vertex, n, "triangle", t);
    if (!soup.labels.empty() && soup.labels.size() != soup.triangles.size())
        refuse(function, std::to_string(soup.labels.size()) + " labels for " + std::to_string(soup.triangles.size()) +
                             " triangles");
    for (std::size_t e = 0; e < soup.edges.size(); ++e)
        for (const int vertex : soup.edges[e]) check_vertex(function, vertex, n, "edge", e);
    if (!soup.edge_labels.empty() && soup.edge_labels.size() != soup.edges.size())
        refuse(function,
               std::to_string(soup.edge_labels.size()) + " labels for " + std::to_string(soup.edges.size()) + " edges");
    for (std::size_t c = 0; c < soup.corners.size(); ++c) check_vertex(function, soup.corners[c], n, "corner", c);
    const RequiredElements& required = soup.required;
    for (std::size_t v = 0; v < required.vertices.size(); ++v)
        check_vertex(function, required.vertices[v], n, "required vertex", v);
    for (std::size_t e = 0; e < required.edges.size(); ++e)
        for (const int vertex : required.edges[e]) check_vertex(function, vertex, n, "required edge", e);
    for (const int t : required.triangles)
        if (t < 0 || static_cast<std::size_t>(t) >= soup.triangles.size())
            refuse(function,
                   "triangle " + std::to_string(t) + " is required of " + std::to_string(soup.triangles.size()));
    for (std::size_t p = 0; p < soup.parameters.size(); ++p) {
        const auto& [vertex, at] = soup.parameters[p];
        check_vertex(function, vertex, n, "parameter entry", p);
        if (at.patch < 0 || !at.uv.allFinite())
            refuse(function, "parameter entry " + std::to_string(p) + " has no patch or is not finite");
    }
}

void io::check_writable(const char* function, const std::vector<Field>& fields, std::size_t count, const char* where) {
    std::set<std::string> names;
    for (const Field& field : fields) {
        const std::string name = std::string(where) + " field '" + field.name + "'";
        if (field.name.empty() || !names.insert(field.name).second)
            refuse(function, name + ": a name must be given, and once");
        if (field.components < 1 || field.values.size() != count * static_cast<std::size_t>(field.components))
            refuse(function, name + " has " + std::to_string(field.values.size()) + " numbers for " +
                                 std::to_string(count) + " times " + std::to_string(field.components) + " components");
    }
}

void io::drop_if_zero(std::vector<int>& labels) {
    if (std::all_of(labels.begin(), labels.end(), [](int label) { return label == 0; })) labels.clear();
}

bool io::holds_integers(const Field& field) {
    constexpr double kExact = 9007199254740992;  // 2^53
    return field.integer && std::all_of(field.values.begin(), field.values.end(),
                                        [](double x) { return std::abs(x) <= kExact && x == std::trunc(x); });
}

std::vector<Field> io::cell_fields_of(const MeshData& data) {
    std::vector<Field> fields = data.cell_fields;
    if (!data.soup.labels.empty()) std::erase_if(fields, [](const Field& field) { return field.name == kLabelField; });
    return fields;
}

TriangleSoup read_mesh(const std::string& path) {
    const MeshFormat& format = format_of(path, kMeshFormats);
    return format.parse(path, read_filled_file(path), io::Fields::Skipped).soup;
}

MeshData read_mesh_data(const std::string& path) {
    const MeshFormat& format = format_of(path, kMeshFormats);
    return format.parse(path, read_filled_file(path), io::Fields::Read);
}

std::vector<Field> read_solution(const std::string& path, std::optional<std::size_t> expected_count) {
    const SizeFormat& format = format_of(path, kSizeFormats);
    std::vector<Field> fields = format.parse_fields(path, read_filled_file(path), expected_count);
    const std::string name = std::filesystem::path(path).stem().string();
    for (std::size_t i = 0; i < fields.size(); ++i)
        fields[i].name = fields.size() == 1 ? name : name + "_" + std::to_string(i + 1);
    return fields;
}

bool holds_fields(const std::string& path) {
    const std::string extension = io::extension_of(path);
    return std::any_of(std::begin(kMeshFormats), std::end(kMeshFormats), [&](const MeshFormat& format) {
        return extension == format.extension && format.fields && format.binary != nullptr;
    });
}

bool holds_labels(const std::string& path) {
    const std::string extension = io::extension_of(path);
    return extension != ".obj" && extension != ".off" && extension != ".stl";
}

bool marks_required(const std::string& path) {
    const std::string extension = io::extension_of(path);
    return extension == ".mesh" || extension == ".meshb";
}

namespace {

void write_as(const MeshFormat& format, const std::string& path, const MeshData& data, const WriteOptions& options) {
    if (format.text == nullptr)
        throw IoError(path, 0, std::string("the format ") + format.extension + " is only read, not written");
    write_file(path, options.ascii ? format.text(data) : format.binary(data));
}

}  // namespace

void write_mesh(const std::string& path, const TriangleSoup& soup, const WriteOptions& options) {
    const MeshFormat& format = format_of(path, kMeshFormats);
    io::check_writable("write_mesh", soup);
    MeshData data{soup};
    // meshio, for one, fails on numbers on the faces of a binary file: what did not ask for them gets none.
    if (format.parse == io::parse_ply) data.soup.labels.clear();
    write_as(format, path, data, options);
}

void write_mesh_data(const std::string& path, const MeshData& data, const WriteOptions& options) {
    const MeshFormat& format = format_of(path, kMeshFormats);
    io::check_writable("write_mesh_data", data.soup);
    io::check_writable("write_mesh_data", data.point_fields, data.soup.points.size(), "point");
    io::check_writable("write_mesh_data", data.cell_fields, data.soup.triangles.size(), "cell");
    for (const auto* fields : {&data.point_fields, &data.cell_fields})
        for (const Field& field : *fields) {
            if (!format.fields)
                throw IoError(path, 0,
                              std::string("the format ") + format.extension + " holds no fields; .msh .ply .vtu do");
            if (std::string_view(format.extension) == ".msh" && field.components > io::kMostComponents)
                throw IoError(path, 0,
                              "field '" + field.name + "' has " + std::to_string(field.components) +
                                  " components; .msh holds up to " + std::to_string(io::kMostComponents));
        }
    write_as(format, path, data, options);
}

std::vector<double> read_sizes(const std::string& path, std::optional<std::size_t> expected_count) {
    const SizeFormat& format = format_of(path, kSizeFormats);
    return format.parse(path, read_filled_file(path), expected_count);
}

void write_sizes(const std::string& path, std::span<const double> sizes, int dimension) {
    const SizeFormat& format = format_of(path, kSizeFormats);
    for (std::size_t i = 0; i < sizes.size(); ++i)
        if (!(sizes[i] > 0))
            throw std::invalid_argument("write_sizes: the size of vertex " + std::to_string(i) + " is " +
                                        std::to_string(sizes[i]) + ", but must be > 0");
    write_file(path, format.contents(sizes, 1, dimension));
}

std::vector<Tensor> read_metrics(const std::string& path, std::optional<std::size_t> expected_count) {
    const SizeFormat& format = format_of(path, kSizeFormats);
    return format.parse_metrics(path, read_filled_file(path), expected_count);
}

void write_metrics(const std::string& path, std::span<const Tensor> metrics, int dimension) {
    const SizeFormat& format = format_of(path, kSizeFormats);
    const int components = dimension == 2 ? 3 : 6;
    std::vector<double> values;
    values.reserve(components * metrics.size());
    for (std::size_t i = 0; i < metrics.size(); ++i) {
        if (!is_positive_definite(metrics[i]))
            throw std::invalid_argument("write_metrics: the metric of vertex " + std::to_string(i) +
                                        " is not positive definite");
        values.insert(values.end(), metrics[i].v.begin(), metrics[i].v.begin() + components);
    }
    write_file(path, format.contents(values, components, dimension));
}

}  // namespace gradus
