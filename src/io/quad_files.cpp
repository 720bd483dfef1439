#include "gradus/io/quad_files.hpp"

#include <algorithm>
#include <iterator>
#include <span>

#include "formats.hpp"
#include "gradus/io/error.hpp"
#include "gradus/io/output_file.hpp"
#include "text_writer.hpp"

namespace gradus {

namespace {

using io::TextWriter;

TextWriter writer_for(const QuadMesh& mesh) {
    return TextWriter(70 * mesh.points.size() + 40 * (mesh.quads.size() + mesh.triangles.size()) + 1024);
}

int label_of(const std::vector<int>& labels, std::size_t i) { return i < labels.size() ? labels[i] : 0; }

void corners(TextWriter& out, std::span<const int> v, int first) {
    for (std::size_t k = 0; k < v.size(); ++k) {
        if (k > 0) out << ' ';
        out << v[k] + first;
    }
}

template <class Elements>
void medit_section(TextWriter& out, std::string_view name, const Elements& elements, const std::vector<int>& labels) {
    if (elements.empty()) return;
    out << '\n' << name << '\n' << elements.size() << '\n';
    for (std::size_t i = 0; i < elements.size(); ++i) {
        corners(out, elements[i], 1);
        out << ' ' << label_of(labels, i) << '\n';
    }
}

std::string medit(const QuadMesh& mesh) {
    TextWriter out = writer_for(mesh);
    out << "MeshVersionFormatted 2\nDimension " << mesh.dimension << "\n\nVertices\n" << mesh.points.size() << '\n';
    for (const Eigen::Vector3d& p : mesh.points) {
        out << p.x() << ' ' << p.y();
        if (mesh.dimension == 3) out << ' ' << p.z();
        out << " 0\n";
    }
    medit_section(out, "Quadrilaterals", mesh.quads, mesh.quad_labels);
    medit_section(out, "Triangles", mesh.triangles, mesh.triangle_labels);
    medit_section(out, "Edges", mesh.edges, mesh.edge_labels);
    if (!mesh.edges.empty()) {
        out << "\nRidges\n" << mesh.edges.size() << '\n';
        for (std::size_t i = 1; i <= mesh.edges.size(); ++i) out << i << '\n';
    }
    if (!mesh.corners.empty()) {
        out << "\nCorners\n" << mesh.corners.size() << '\n';
        for (const int v : mesh.corners) out << v + 1 << '\n';
    }
    out << "\nEnd\n";
    return out.take();
}

std::string vtu(const QuadMesh& mesh) {
    constexpr int kLine = 3, kTriangle = 5, kQuad = 9;
    const std::size_t cells = mesh.quads.size() + mesh.triangles.size() + mesh.edges.size();
    TextWriter out = writer_for(mesh);
    out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\">\n<UnstructuredGrid>\n"
        << "<Piece NumberOfPoints=\"" << mesh.points.size() << "\" NumberOfCells=\"" << cells << "\">\n<Points>\n"
        << "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n";
    for (const Eigen::Vector3d& p : mesh.points) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    out << "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n";
    const auto for_each_cell = [&](const auto& use) {
        for (std::size_t i = 0; i < mesh.quads.size(); ++i) use(mesh.quads[i], kQuad, label_of(mesh.quad_labels, i));
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            use(mesh.triangles[i], kTriangle, label_of(mesh.triangle_labels, i));
        for (std::size_t i = 0; i < mesh.edges.size(); ++i) use(mesh.edges[i], kLine, label_of(mesh.edge_labels, i));
    };
    for_each_cell([&](std::span<const int> v, int, int) { corners(out, v, 0), out << '\n'; });
    out << "</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n";
    std::size_t end = 0;
    for_each_cell([&](std::span<const int> v, int, int) { out << (end += v.size()) << '\n'; });
    out << "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n";
    for_each_cell([&](std::span<const int>, int type, int) { out << type << '\n'; });
    out << "</DataArray>\n</Cells>\n<CellData>\n<DataArray type=\"Int32\" Name=\"label\" format=\"ascii\">\n";
    for_each_cell([&](std::span<const int>, int, int label) { out << label << '\n'; });
    out << "</DataArray>\n</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    return out.take();
}

std::string obj(const QuadMesh& mesh) {
    TextWriter out = writer_for(mesh);
    for (const Eigen::Vector3d& p : mesh.points) out << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    const auto face = [&](std::span<const int> v) { out << "f ", corners(out, v, 1), out << '\n'; };
    for (const auto& v : mesh.quads) face(v);
    for (const auto& v : mesh.triangles) face(v);
    return out.take();
}

std::string off(const QuadMesh& mesh) {
    TextWriter out = writer_for(mesh);
    out << "OFF\n" << mesh.points.size() << ' ' << mesh.quads.size() + mesh.triangles.size() << " 0\n";
    for (const Eigen::Vector3d& p : mesh.points) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    const auto face = [&](std::span<const int> v) { out << v.size() << ' ', corners(out, v, 0), out << '\n'; };
    for (const auto& v : mesh.quads) face(v);
    for (const auto& v : mesh.triangles) face(v);
    return out.take();
}

struct QuadFormat {
    const char* extension;
    std::string (*contents)(const QuadMesh&);
};
constexpr QuadFormat kFormats[] = {{".mesh", medit}, {".vtu", vtu}, {".obj", obj}, {".off", off}};

const QuadFormat* format_of(const std::string& path) {
    const std::string extension = io::extension_of(path);
    const auto* found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                     [&](const QuadFormat& format) { return extension == format.extension; });
    return found == std::end(kFormats) ? nullptr : found;
}

}  // namespace

bool holds_quads(const std::string& path) { return format_of(path) != nullptr; }

void write_quads(const std::string& path, const QuadMesh& mesh) {
    const QuadFormat* format = format_of(path);
    if (!format) throw IoError(path, 0, "no format for quadrilaterals; known are .mesh .vtu .obj .off");
    write_file(path, format->contents(mesh));
}

}  // namespace gradus
