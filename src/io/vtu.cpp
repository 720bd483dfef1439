// VTK's unstructured grid in XML, its data appended as raw binary in double precision.
#include <limits>

#include "bytes.hpp"
#include "formats.hpp"
#include "markup.hpp"

namespace gradus {
namespace {

/// The XML head, which names the arrays by their offset, and the data that is appended to it.
class Arrays {
  public:
    explicit Arrays(std::size_t expected) { data_.reserve(expected); }

    std::string xml;

    void open(const char* type, const std::string& name, int components, std::size_t bytes) {
        xml += std::string("<DataArray type=\"") + type + "\" Name=\"" + markup::escape(name) +
               "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"appended\" offset=\"" +
               std::to_string(data_.size()) + "\"/>\n";
        io::append_bytes(data_, static_cast<std::uint64_t>(bytes));
    }
    template <class Number>
    void append(Number value) {
        io::append_bytes(data_, value);
    }
    const std::string& data() const { return data_; }

  private:
    std::string data_;
};

/// @param others  cells behind those with values
void add_field(Arrays& arrays, const Field& field, std::size_t others) {
    const std::size_t missing = others * static_cast<std::size_t>(field.components);
    const bool integers = io::holds_integers(field);
    arrays.open(integers ? "Int64" : "Float64", field.name, field.components, 8 * (field.values.size() + missing));
    for (const double value : field.values)
        integers ? arrays.append(static_cast<std::int64_t>(value)) : arrays.append(value);
    for (std::size_t i = 0; i < missing; ++i)
        integers ? arrays.append(std::int64_t{0}) : arrays.append(std::numeric_limits<double>::quiet_NaN());
}

void add_labels(Arrays& arrays, const TriangleSoup& soup) {
    arrays.open("Int32", std::string(io::kLabelField), 1, 4 * (soup.triangles.size() + soup.edges.size()));
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
        arrays.append(std::int32_t{soup.labels.empty() ? 0 : soup.labels[t]});
    for (std::size_t e = 0; e < soup.edges.size(); ++e)
        arrays.append(std::int32_t{soup.edge_labels.empty() ? 0 : soup.edge_labels[e]});
}

void add_points(Arrays& arrays, std::span<const Eigen::Vector3d> points) {
    arrays.xml += "<Points>\n";
    arrays.open("Float64", "Points", 3, 24 * points.size());
    for (const Eigen::Vector3d& point : points)
        for (int i = 0; i < 3; ++i) arrays.append(point[i]);
    arrays.xml += "</Points>\n";
}

using Edges = std::span<const std::array<int, 2>>;

void add_cells(Arrays& arrays, std::span<const Triangle> triangles, Edges edges) {
    constexpr std::uint8_t kVtkLine = 3, kVtkTriangle = 5;
    arrays.xml += "<Cells>\n";
    arrays.open("Int32", "connectivity", 1, 12 * triangles.size() + 8 * edges.size());
    for (const Triangle& triangle : triangles)
        for (const int vertex : triangle) arrays.append(std::int32_t{vertex});
    for (const auto& edge : edges)
        for (const int vertex : edge) arrays.append(std::int32_t{vertex});
    arrays.open("Int64", "offsets", 1, 8 * (triangles.size() + edges.size()));
    for (std::size_t t = 1; t <= triangles.size(); ++t) arrays.append(static_cast<std::int64_t>(3 * t));
    for (std::size_t e = 1; e <= edges.size(); ++e)
        arrays.append(static_cast<std::int64_t>(3 * triangles.size() + 2 * e));
    arrays.open("UInt8", "types", 1, triangles.size() + edges.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) arrays.append(kVtkTriangle);
    for (std::size_t e = 0; e < edges.size(); ++e) arrays.append(kVtkLine);
    arrays.xml += "</Cells>\n";
}

std::string head_of(std::size_t points, std::size_t cells) {
    return "<?xml version=\"1.0\"?>\n"
           "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<UnstructuredGrid>\n"
           "<Piece NumberOfPoints=\"" +
           std::to_string(points) + "\" NumberOfCells=\"" + std::to_string(cells) + "\">\n";
}

std::string file_of(Arrays& arrays) {
    arrays.xml += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    return arrays.xml + arrays.data() + "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace

std::string io::vtu_binary(const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    const std::size_t cells = soup.triangles.size() + soup.edges.size();
    const std::vector<Field> cell_fields = cell_fields_of(data);
    std::size_t numbers = 0;
    for (const auto* fields : {&data.point_fields, &cell_fields})
        for (const Field& field : *fields) numbers += field.values.size();
    Arrays arrays(24 * soup.points.size() + 25 * cells + 8 * numbers + 4096);
    arrays.xml = head_of(soup.points.size(), cells);
    if (!data.point_fields.empty()) {
        arrays.xml += "<PointData>\n";
        for (const Field& field : data.point_fields) add_field(arrays, field, 0);
        arrays.xml += "</PointData>\n";
    }
    const bool has_labels = !soup.labels.empty() || !soup.edge_labels.empty();
    if (has_labels || !cell_fields.empty()) {
        arrays.xml += "<CellData>\n";
        for (const Field& field : cell_fields) add_field(arrays, field, soup.edges.size());
        if (has_labels) add_labels(arrays, soup);
        arrays.xml += "</CellData>\n";
    }
    add_points(arrays, soup.points);
    add_cells(arrays, soup.triangles, soup.edges);
    return file_of(arrays);
}

}  // namespace gradus
