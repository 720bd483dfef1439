#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/damage.hpp"
#include "support/files.hpp"
#include "support/soups.hpp"
#include "support/vtk_files.hpp"

using namespace gradus;
using namespace support::vtk;
using support::put;
using support::TemporaryFolder;

namespace {

MeshData read_text(const TemporaryFolder& folder, const std::string& name, std::string_view text) {
    support::spill(folder / name, text);
    return read_mesh_data(folder / name);
}

}  // namespace

TEST_CASE("VTK files in all encodings are read, with their fields", "[io][vtk]") {
    const TemporaryFolder folder;
    const Format format = GENERATE(Format::Inline, Format::AppendedRaw, Format::AppendedBase64);
    const bool big = GENERATE(false, true), wide = GENERATE(false, true), compressed = GENERATE(false, true);
    CAPTURE(format, big, wide, compressed);
    const MeshData data = read_text(folder, "a.vtu", two_pieces(Writer(format, big, wide, compressed)));
    CHECK(data.soup.triangles ==
          std::vector<Triangle>{{3, 2, 4}, {0, 1, 2}, {0, 2, 3}, {5, 6, 7}, {5, 7, 8}, {5, 8, 9}});
    CHECK(data.soup.edges == std::vector<std::array<int, 2>>{{0, 1}});
    CHECK(data.soup.labels == std::vector{3, -4, -4, 8, 8, 8});
    REQUIRE(data.soup.points.size() == 10);
    CHECK(data.soup.points[4] == Eigen::Vector3d(1.0 / 3, 2, 0));
    CHECK(data.soup.points[7] == Eigen::Vector3d(2, 1, 9));
    REQUIRE(data.point_fields.size() == 1);  // that all pieces have
    CHECK(data.point_fields[0].name == "size");
    CHECK(data.point_fields[0].values ==
          std::vector{0.1, 1e300, std::numeric_limits<double>::infinity(), 5e-324, -0.0, 1.0, 2.0, 3.0, 4.0, 5.0});
    REQUIRE(data.cell_fields.size() == 3);
    CHECK(data.cell_fields[0].values == std::vector{-1.0, 7.0, 7.0, 65535.0, 65535.0, 65535.0});
    CHECK(data.cell_fields[1].components == 2);
    CHECK(data.cell_fields[1].values ==
          std::vector{1.0, 2.0, 9007199254740992.0, 4.0, 9007199254740992.0, 4.0, 0.5, 0.25, 0.5, 0.25, 0.5, 0.25});
    CHECK(read_mesh(folder / "a.vtu").triangles == data.soup.triangles);
}

TEST_CASE("a header in base64 on its own, as some write it without compression, is read", "[io][vtk]") {
    const TemporaryFolder folder;
    std::string head, points;
    put(head, std::uint32_t{24});
    for (const double x : {1.5, 2.5, 3.5}) put(points, x);
    const MeshData data = read_text(
        folder, "a.vtp",
        "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"1\"><Points>"
        "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"binary\">" +
            base64(head) + base64(points) + "</DataArray></Points></Piece></PolyData></VTKFile>");
    REQUIRE(data.soup.points.size() == 1);
    CHECK(data.soup.points[0] == Eigen::Vector3d(1.5, 2.5, 3.5));
}

TEST_CASE("VTK's kinds of cells in text become triangles and edges", "[io][vtk]") {
    const TemporaryFolder folder;
    const std::string key =
        "<InformationKey name=\"RANGE\" location=\"vtkDataArray\" length=\"2\"><Value "
        "index=\"0\">\n1\n</Value></InformationKey>\n";
    const MeshData data = read_text(
        folder, "a.vtu",
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
        "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
        "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" format=\"ascii\">0</DataArray></FieldData>\n"
        "<Piece NumberOfPoints=\"9\" NumberOfCells=\"9\">\n<PointData><DataArray type=\"String\" Name=\"s\" "
        "format=\"ascii\">1 "
        "2</DataArray>"
        "<DataArray type=\"Float32\" Name=\"v\" format=\"ascii\">" +
            key + "0 1 2 3 4 5 nan -inf 8" + key +
            "</DataArray></PointData>\n"
            "<Points><DataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n"
            "0 0 0 1 0 0 0 1 0 1 1 0 .5 0 0 1 .5 0 .5 .5 0 0 .5 0 7 7 7\n" +
            key +
            "</DataArray></Points>\n"
            "<Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n"
            "8  8 8  0 1 3 2  0 1 2 3  0 1 3  0 1 3 4 5 6  0 1 3 2 4 5 6 7  0 1 4  0 1 3 2\n</DataArray>\n"
            "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">1 3 7 11 14 20 28 31 35</DataArray>\n"
            "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">1 2 4 8 7 22 23 21 6</DataArray></Cells>\n"
            "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    CHECK(data.soup.edges == std::vector<std::array<int, 2>>{{0, 1}, {1, 3}, {3, 2}, {0, 1}});
    CHECK(data.soup.triangles == std::vector<Triangle>{{0, 1, 3},
                                                       {0, 3, 2},  // pixel
                                                       {0, 1, 3},  // polygon
                                                       {0, 1, 3},  // second order
                                                       {0, 1, 3},
                                                       {0, 3, 2},  // second order
                                                       {0, 1, 3},
                                                       {3, 1, 2}});  // strip
    REQUIRE(data.soup.points.size() == 5);                           // without the middles of sides
    CHECK(data.soup.points[4] == Eigen::Vector3d(7, 7, 7));
    REQUIRE(data.point_fields.size() == 1);
    CHECK(data.point_fields[0].values == std::vector{0.0, 1.0, 2.0, 3.0, 8.0});
}

TEST_CASE("VTK polygons are read, cells in the order of VTK", "[io][vtk]") {
    const TemporaryFolder folder;
    const auto cells = [](const char* name, const char* connectivity, const char* offsets) {
        return std::string("<") + name + "><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" +
               connectivity + "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">" + offsets +
               "</DataArray></" + name + ">\n";
    };
    const MeshData data =
        read_text(folder, "a.vtp",
                  "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"4\" "
                  "NumberOfVerts=\"1\" "
                  "NumberOfLines=\"1\" "
                  "NumberOfStrips=\"1\" NumberOfPolys=\"1\">\n"
                  "<CellData><DataArray type=\"Int32\" Name=\"c\" format=\"ascii\">10 20 30 40</DataArray></CellData>\n"
                  "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 "
                  "0</DataArray></Points>\n" +
                      cells("Verts", "0 1", "2") + cells("Lines", "0 1 2", "3") + cells("Strips", "0 1 3", "3") +
                      cells("Polys", "0 1 2 3", "4") + "</Piece></PolyData></VTKFile>\n");
    CHECK(data.soup.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}});
    CHECK(data.soup.edges == std::vector<std::array<int, 2>>{{0, 1}, {1, 2}});
    REQUIRE(data.cell_fields.size() == 1);
    CHECK(data.cell_fields[0].values == std::vector{30.0, 30.0, 40.0});
}

TEST_CASE("fields of .vtu are read back with all values", "[io][vtk]") {
    const TemporaryFolder folder;
    const TriangleSoup soup = support::wild_soup(4);
    std::mt19937_64 random(5);
    std::vector<double> size, flow;
    for (std::size_t i = 0; i < soup.points.size(); ++i) size.push_back(support::any_double(random));
    for (std::size_t i = 0; i < 3 * soup.triangles.size(); ++i) flow.push_back(support::any_double(random));
    write_mesh_data(
        folder / "a.vtu",
        {{.points = soup.points, .triangles = soup.triangles}, {{"size & <scale>", 1, size}}, {{"flow", 3, flow}}});
    const MeshData data = read_mesh_data(folder / "a.vtu");
    CHECK(support::same_points(data.soup, soup));
    CHECK(data.soup.triangles == soup.triangles);
    REQUIRE(data.point_fields.size() == 1);
    CHECK(data.point_fields[0].name == "size & <scale>");
    CHECK(data.point_fields[0].values == size);
    REQUIRE(data.cell_fields.size() == 1);
    CHECK(data.cell_fields[0].components == 3);
    CHECK(data.cell_fields[0].values == flow);
}

namespace {

/// A valid file of one triangle, with one thing replaced. What is replaced starts in the line given.
std::string one_triangle(const std::string& part = "", const std::string& by = "") {
    std::string text =
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
        "<Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">\n<PointData>\n"
        "<DataArray type=\"Float64\" Name=\"f\" format=\"ascii\">1 2 3</DataArray>\n</PointData>\n<Points>\n"
        "<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0\n1 0 0\n0 1 "
        "0\n</DataArray>\n</Points>\n"
        "<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\n"
        "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray>\n"
        "<DataArray type=\"UInt8\" Name=\"types\" "
        "format=\"ascii\">5</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    if (!part.empty()) {
        REQUIRE(text.find(part) != std::string::npos);
        text.replace(text.find(part), part.size(), by);
    }
    return text;
}

}  // namespace

TEST_CASE("malformed VTK files are refused with the path and the line", "[io][vtk]") {
    const TemporaryFolder folder;
    REQUIRE(read_text(folder, "a.vtu", one_triangle()).soup.triangles.size() == 1);
    struct Case {
        const char *part, *by;
        int line;
        const char* says;
    };
    const Case cases[] = {
        {"<VTKFile", "VTKFile", 1, "syntax error"},
        {"<VTKFile", "<!DOCTYPE x [<!ENTITY a \"b\">]>\n<VTKFile", 1, "document type"},
        {"UnstructuredGrid", "ImageData", 1, "'ImageData' is not supported"},
        {"LittleEndian", "MiddleEndian", 1, "'MiddleEndian'"},
        {" byte_order", " compressor=\"vtkLZ4DataCompressor\" byte_order", 1, "'vtkLZ4DataCompressor'"},
        {" byte_order", " header_type=\"UInt16\" byte_order", 1, "'UInt16'"},
        {"NumberOfPoints=\"3\"", "NumberOfPoints=\"4\"", 8, "has 9 numbers, expected 12"},
        {"NumberOfPoints=\"3\"", "NumberOfPoints=\"2\"", 8, "has 9 numbers, expected 6"},
        {"NumberOfPoints=\"3\"", "NumberOfPoints=\"-3\"", 3, "not a number"},
        {"NumberOfPoints=\"3\"", "NumberOfPoints=\"99999999999\"", 3, "more than any file"},
        {"NumberOfCells=\"1\"", "NumberOfCells=\"2000000000\"", 17, "has 1 numbers, expected 2000000000"},
        {"Components=\"3\"", "Components=\"2\"", 8, "points have 3"},
        {"1 0 0\n", "1 0 nan\n", 8, "not finite, of point 1"},
        {"1 0 0\n", "1 x 0\n", 10, "found 'x'"},
        {"1 2 3<", "1 2 y<", 5, "found 'y'"},
        {"1 2 3<", "1 2<", 5, "has 2 numbers, expected 3"},
        {">0 1 2<", ">0 1 3<", 15, "point 3, which is out of range; there are 3"},
        {">0 1 2<", ">0 -1 2<", 15, "point -1"},
        {">0 1 2<", ">0 1 2.5<", 15, "'2.5'"},
        {">0 1 2<", ">0 1 2 2<", 15, "has 4 numbers, expected 3"},
        {">3</DataArray>\n<DataArray type=\"UInt8\"", ">4</DataArray>\n<DataArray type=\"UInt8\"", 16,
         "out of order or range"},
        {">3</DataArray>\n<DataArray type=\"UInt8\"", ">-1</DataArray>\n<DataArray type=\"UInt8\"", 16,
         "out of order or range"},
        {">5<", ">9<", 16, "3 nodes, but it is one of the quads with 4"},
        {">5<", ">10<", 17, "holds tetrahedra; give a surface mesh"},
        {">5<", ">42<", 17, "holds polyhedra"},
        {">5<", ">99<", 17, "type 99"},
        {"Int32", "Float64", 15, "must be of integers"},
        {"Float64\" Name=\"Points", "Real\" Name=\"Points", 8, "unknown type 'Real'"},
        {"\"offsets\"", "\"offset\"", 3, "no array 'offsets'"},
        {"</Cells>", "", 19, "mismatched tag"},
        {"</VTKFile>\n", "", 21, "no element found"},
        {"\"f\" format=\"ascii\"", "\"f\" format=\"text\"", 5, "'text'"},
        {"\"f\" format=\"ascii\"", "\"f\" format=\"appended\" offset=\"0\"", 5, "no appended data"},
        {"</UnstructuredGrid>\n", "</UnstructuredGrid>\n<AppendedData encoding=\"base64\"/>_\n", 21,
         "ends before its data"},
        {"\"f\" format=\"ascii\">1 2 3", "\"f\" format=\"binary\">GAAAAAAAAAA=", 5, "shorter than its header says"},
        {"\"f\" format=\"ascii\">1 2 3", "\"f\" format=\"binary\">/////wAAAAA=", 5, "shorter than its header says"},
        {"\"f\" format=\"ascii\">1 2 3", "\"f\" format=\"binary\">GA?A", 5, "not in base64"},
        {"\"f\" format=\"ascii\">1 2 3", "\"f\" format=\"binary\">BwAAAAAAAAAAAAA=", 5, "7 bytes, no multiple of 8"},
    };
    for (const auto& [part, by, line, says] : cases)
        support::check_refused(folder / "a.vtu", one_triangle(part, by), line, says,
                               [](const std::string& path) { read_mesh_data(path); });
    support::check_refused(folder / "a.vtu", "<VTKFile type=\"PolyData\">\n</VTKFile>\n", 3, "no Piece",
                           [](const std::string& path) { read_mesh(path); });
    support::check_refused(folder / "a.vtu", "<html/>", 1, "not a VTK file",
                           [](const std::string& path) { read_mesh(path); });
}

TEST_CASE("compressed VTK data that claims to be huge is refused before it is unpacked", "[io][vtk]") {
    const TemporaryFolder folder;
    const auto file = [](std::initializer_list<std::uint32_t> header) {
        std::string bytes;
        for (const std::uint32_t number : header) put(bytes, number);
        return "<VTKFile type=\"PolyData\" compressor=\"vtkZLibDataCompressor\"><PolyData>\n<Piece "
               "NumberOfPoints=\"1\"><Points>\n"
               "<DataArray type=\"Float64\" Name=\"p\" NumberOfComponents=\"3\" format=\"binary\">" +
               base64(bytes) + base64(deflated(std::string(24, '\0'))) +
               "</DataArray></Points></Piece></PolyData></VTKFile>";
    };
    const auto check = [&](const std::string& contents, const char* says) {
        support::check_refused(folder / "a.vtp", contents, 3, says, [](const std::string& path) { read_mesh(path); });
    };
    const auto packed = static_cast<std::uint32_t>(deflated(std::string(24, '\0')).size());
    CHECK(read_text(folder, "a.vtp", file({1, 24, 0, packed})).soup.points.size() == 1);
    CHECK(read_text(folder, "a.vtp", file({1, 32768, 24, packed})).soup.points.size() == 1);
    check(file({1, 4000000000u, 0, packed}), "too short");
    check(file({1000000000, 24, 0, packed}), "1000000000 blocks");
    check(file({1, 25, 0, packed}), "damaged");
    check(file({1, 23, 0, packed}), "damaged");
    check(file({1, 24, 0, packed - 1}), "damaged");
    check(file({1, 24, 0, packed + 100}), "shorter than its header says");
    check(file({0, 0, 0}), "has 0 numbers, expected 3");
}
