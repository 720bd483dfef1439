#include "support/valid_files.hpp"

#include <fmt/format.h>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "support/files.hpp"
#include "support/medit_files.hpp"
#include "support/msh_files.hpp"
#include "support/soups.hpp"
#include "support/vtk_files.hpp"

namespace support {
namespace {

using gradus::TriangleSoup;

TriangleSoup with_everything() {
    TriangleSoup soup = grid(3);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) soup.labels.push_back(static_cast<int>(t / 6));
    soup.edges = {{0, 1}, {1, 2}};
    soup.corners = {0, 3};
    soup.required = {.vertices = {5, 2}, .edges = {{0, 1}, {3, 4}}, .triangles = {2, 0}};
    soup.parameters = {{0, {1, {0.5, 0.25}}}, {3, {0, {1e-5, 1}}}};
    return soup;
}

/// A closed surface, a copy of it turned round that shares a corner, three triangles at an edge, a flat one, and points
/// to weld.
TriangleSoup to_be_repaired() {
    TriangleSoup soup = tetrahedron();
    soup.points.insert(soup.points.end(),
                       {{0, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0.5, 0.5, 0}, {1, 1, 1}, {2, 2, 2}});
    soup.triangles.insert(soup.triangles.end(),
                          {{4, 5, 6}, {4, 7, 5}, {5, 6, 7}, {4, 6, 7}, {1, 2, 8}, {1, 2, 9}, {1, 1, 10}, {0, 2, 1}});
    return soup;
}

std::string written(const TemporaryFolder& folder, const std::string& extension, const TriangleSoup& soup,
                    bool ascii = false) {
    gradus::write_mesh(folder / ("a" + extension), soup, {.ascii = ascii});
    return gradus::read_file(folder / ("a" + extension));
}

std::string polygons(vtk::Writer writer) {
    std::string piece =
        "<Piece NumberOfPoints=\"4\" NumberOfVerts=\"1\" NumberOfLines=\"1\" NumberOfStrips=\"1\" "
        "NumberOfPolys=\"1\">\n<CellData>\n";
    piece += writer.array<std::int32_t>("Int32", "c", 1, {10, 20, 30, 40}) + "</CellData>\n<Points>\n";
    piece += writer.array<float>("Float32", "Points", 3, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) + "</Points>\n";
    const auto add = [&](const std::string& part, const std::vector<std::int32_t>& nodes) {
        piece += "<" + part + ">\n" + writer.array<std::int32_t>("Int32", "connectivity", 1, nodes) +
                 writer.array<std::int32_t>("Int32", "offsets", 1, {static_cast<std::int32_t>(nodes.size())}) + "</" +
                 part + ">\n";
    };
    add("Verts", {0, 1});
    add("Lines", {0, 1, 2});
    add("Strips", {0, 1, 3});
    add("Polys", {0, 1, 2, 3});
    return writer.file("PolyData", piece + "</Piece>\n");
}

std::string binary_ply(bool big) {
    std::string bytes =
        std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
        " 1.0\nelement vertex 4\nproperty short x\nproperty float y\nproperty char quality\nproperty double z\n"
        "element face 1\nproperty list ushort short vertex_indices\nproperty double area\nelement rest 1\nproperty "
        "list int uchar any\n"
        "end_header\n";
    for (const auto& [x, y] : {std::pair{0, 0.f}, {1, 0.f}, {1, 1.f}, {0, 1.f}}) {
        put(bytes, static_cast<std::int16_t>(x), big);
        put(bytes, y, big);
        put(bytes, std::int8_t{-1}, big);
        put(bytes, 0.25, big);
    }
    put(bytes, std::uint16_t{4}, big);
    for (std::int16_t k = 0; k < 4; ++k) put(bytes, k, big);
    put(bytes, 1.0, big);
    put(bytes, std::int32_t{2}, big);
    return bytes + "ab";
}

/// What other tools write, which the writers of the library do not.
std::vector<ValidFile> of_other_tools() {
    std::vector<ValidFile> files{
        {".obj",
         "# by hand\nmtllib a.mtl\no thing\nv 0 0 0 1\nv 1 0 0 .5 .5 .5\nv +1.0 1e0 0\nvt 0 0\nvn 0 0 1\nusemtl x\nf "
         "1/1/1 2//1 3/1\n"
         "v 0 \\\n 1 0\nf -1 -4 \\\n -2\ns off\nf 1 2 3 4\n"},
        {".off",
         "COFF # colours\n4 2 5\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n1 1 0 1 1 1 1\n\n0 1 0 0 0 0 1\n3 0 1 2 255 0 0\n4 "
         "0 1 2 3\n"},
        {".off", "3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {".ply",
         "ply\nformat ascii 1.0\ncomment x\nelement face 1\nproperty int id\nproperty list uchar int "
         "vertex_index\nelement vertex 4\n"
         "property double z\nproperty float y\nproperty int x\nproperty list uchar int faces\nproperty uchar "
         "red\nend_header\n"
         "7 4 0 1 2 3\n0 0 0 0 1\n0 0 1 1 0 2\n0 1 1 2 0 0 3\n.5 1 0 0 4\n"},
        {".ply", binary_ply(false)},
        {".ply", binary_ply(true)},
        {".stl",
         "solid a b\nFACET NORMAL 0 0 nan\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
         "-0\nendloop\nendfacet\nendsolid a b\n"
         "solid\nendsolid\n"},
        {".mesh",
         "MeshVersionFormatted 1 Dimension 3\nGeometry \"some file.mesh\"\nAngleOfCornerBound 30.5\nTriangles 1 1 2 3 "
         "7 # here\n"
         "Normals\n2\n0 0 1\nnan inf 0\nVertices 4  0 0 0 1  +1.0D0 0 0 1\n1e0 10d-1 0 1 0 1. 0 "
         "1\nQuadrilaterals\n1\n1 2 3 4 9\n"
         "Edges 2 1 2 0 2 3 0 RequiredEdges 1 2 Ridges 1 1 Corners 1 4\nEnd\n"},
        {".mesh",
         "MeshVersionFormatted 2\n\nDimension\n2\nVertices\n3\n0 0 0\n1 0 0\n1 2.5 0\nTriangles\n1\n1 2 3 0\n"},
        {".mesh",
         "MeshVersionFormatted 2\nDimension 2\nVertices\n8\n0 0 0\n3 0 0\n3 3 0\n0 3 0\n1 1 0\n2 1 0\n1 2 0\n.5 .5 "
         "0\nEdges\n7\n1 2 1\n2 3 2\n3 4 "
         "1\n4 1 3\n5 6 4\n6 7 4\n7 5 4\nRequiredEdges\n1\n2\nCorners\n1\n5\nRequiredVertices\n1\n8\nEnd\n"},
        {".poly",
         "# a square with a hole and a line\n9 2 1 1\n1 0 0 5 1\n2 3 0 5 1\n3 3 3 5 1\n4 0 3 5 1\n5 1 1 .5 0\n6 2 1 .5 "
         "0\n7 1 2 .5 0\n8 2.5 1.5 0 0\n9 "
         "2.5 2.5 0 0\n8 1\n1 1 2 7\n2 2 3 8\n3 3 4 9\n4 4 1 9\n5 5 6 1\n6 6 7 1\n7 7 5 1\n8 8 9 2\n1\n1 1.2 1.2\n1\n1 "
         ".1 .1 4 0.5 # size\n"},
        {".poly", "3 2 0 0\n0 0 0\n1 1 0\n2 0 1\n3 0\n0 0 1\n1 1 2\n2 2 0\n0\n"},
        {".msh",
         "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 5 \"wall\"\n$EndPhysicalNames\n$Nodes\n6\n1 0 0 "
         "0\n2 1 0 0\n3 1 1 0\n"
         "4 .5 0 0\n5 1 .5 0\n6 .5 .5 0\n$EndNodes\n$Elements\n3\n1 2 2 5 1 1 2 3\n2 9 3 6 2 0 1 2 3 4 5 6\n7 15 0 "
         "1\n$EndElements\n"
         "$NodeData\n1\n\"x\"\n0\n3\n0\n1\n2\n1 1\n3 2\n$EndNodeData\n$ElementData\n1\n\"y\"\n1\n0.5\n3\n0\n3\n1\n2 1 "
         "2 "
         "3\n$EndElementData\n"},
        {".vtu",
         "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
         "<Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">\n<PointData>\n"
         "<DataArray type=\"Float64\" Name=\"f\" format=\"ascii\">1 2 nan</DataArray>\n</PointData>\n<Points>\n"
         "<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0\n1 0 0\n0 1 "
         "0\n</DataArray>\n"
         "</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\n"
         "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray>\n"
         "<DataArray type=\"UInt8\" Name=\"types\" "
         "format=\"ascii\">5</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"},
    };
    for (const int version : {1, 2, 3, 4}) files.push_back({".meshb", binary_medit(version, version % 2 == 0)});
    for (const bool big : {false, true})
        for (const int version : {2, 4}) files.push_back({".msh", binary_msh(version, big)});
    for (const vtk::Format format : {vtk::Format::Inline, vtk::Format::AppendedRaw, vtk::Format::AppendedBase64})
        for (const bool compressed : {false, true}) {
            files.push_back({".vtu", vtk::two_pieces(vtk::Writer(format, compressed, !compressed, compressed))});
            files.push_back({".vtp", polygons(vtk::Writer(format, !compressed, compressed, compressed))});
        }
    return files;
}

}  // namespace

std::vector<ValidFile> valid_mesh_files() {
    const TemporaryFolder folder;
    std::vector<ValidFile> files;
    for (const TriangleSoup& soup : {with_everything(), to_be_repaired()}) {
        for (const char* extension : {".mesh", ".meshb", ".msh", ".obj", ".off", ".ply", ".stl", ".vtu"})
            files.push_back({extension, written(folder, extension, soup)});
        for (const char* extension : {".ply", ".stl"})
            files.push_back({extension, written(folder, extension, soup, true)});
    }
    for (ValidFile& file : of_other_tools()) files.push_back(std::move(file));
    return files;
}

std::vector<ValidFile> valid_size_files() {
    const TemporaryFolder folder;
    std::vector<ValidFile> files;
    for (const char* extension : {".sol", ".solb"}) {
        const std::filesystem::path path = folder / fmt::format("a{}", extension);
        gradus::write_sizes(path, std::vector<double>(kSizesInFile, 0.3));
        files.push_back({extension, gradus::read_file(path)});
    }
    return files;
}

}  // namespace support
