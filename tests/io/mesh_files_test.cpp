#include "gradus/io/mesh_files.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "gradus/io/error.hpp"
#include "gradus/io/input_file.hpp"
#include "gradus/io/output_file.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/damage.hpp"
#include "support/files.hpp"
#include "support/medit_files.hpp"
#include "support/soups.hpp"

using namespace gradus;
using support::put;
using support::same_bits;
using support::same_points;
using support::TemporaryFolder;
using support::wild_soup;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Corner by corner, whatever the vertices are numbered.
bool same_corners(const TriangleSoup& a, const TriangleSoup& b) {
    if (a.triangles.size() != b.triangles.size()) return false;
    for (std::size_t t = 0; t < a.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            if (!same_bits(a.points[a.triangles[t][k]], b.points[b.triangles[t][k]])) return false;
    return true;
}

bool same_parameters(const TriangleSoup& a, const TriangleSoup& b) {
    return std::equal(a.parameters.begin(), a.parameters.end(), b.parameters.begin(), b.parameters.end(),
                      [](const auto& p, const auto& q) {
                          return p.vertex == q.vertex && p.at.patch == q.at.patch &&
                                 same_bits(p.at.uv[0], q.at.uv[0]) && same_bits(p.at.uv[1], q.at.uv[1]);
                      });
}

TriangleSoup read_text(const TemporaryFolder& folder, const std::string& name, std::string_view text) {
    support::spill(folder / name, text);
    return read_mesh(folder / name);
}

const std::vector<Triangle> kTwo{{0, 1, 2}, {0, 2, 3}};

}  // namespace

TEST_CASE("every format gives back the same bits", "[io][property]") {
    const TemporaryFolder folder;
    const unsigned seed = GENERATE(range(0u, 8u));
    const TriangleSoup soup = wild_soup(seed);
    struct Case {
        const char* name;
        bool ascii;
    };
    for (const auto& [name, ascii] :
         {Case{"a.mesh", false}, Case{"a.meshb", false}, Case{"a.obj", false}, Case{"a.OFF", false},
          Case{"a.ply", false}, Case{"b.ply", true}, Case{"a.vtu", false}}) {
        INFO(name << " ascii " << ascii << " seed " << seed);
        write_mesh(folder / name, soup, {.ascii = ascii});
        const TriangleSoup back = read_mesh(folder / name);
        CHECK(same_points(soup, back));
        CHECK(soup.triangles == back.triangles);
        if (std::string(name).starts_with("a.mesh") || name == std::string("a.vtu")) {
            CHECK(soup.labels == back.labels);
            CHECK(soup.edges == back.edges);
        }
        if (std::string(name).starts_with("a.mesh")) {
            CHECK(same_parameters(soup, back));
            CHECK(soup.corners == back.corners);
            CHECK(soup.required == back.required);
        }
    }
    write_mesh(folder / "a.stl", soup, {.ascii = true});
    CHECK(same_corners(soup, read_mesh(folder / "a.stl")));
}

TEST_CASE("binary STL keeps what single precision holds, and refuses what it does not", "[io]") {
    const TemporaryFolder folder;
    TriangleSoup soup = support::grid(9);
    for (Eigen::Vector3d& p : soup.points) p = p.cast<float>().cast<double>();
    write_mesh(folder / "a.stl", soup);
    const TriangleSoup back = read_mesh(folder / "a.stl");
    CHECK(same_corners(soup, back));
    CHECK(back.points.size() == soup.points.size());
    soup.points[0].x() = 1e300;
    CHECK_THROWS_AS(write_mesh(folder / "a.stl", soup), std::invalid_argument);
}

TEST_CASE("sizes give back the same bits, unset ones too", "[io]") {
    const TemporaryFolder folder;
    const std::string name = GENERATE("a.sol", "a.solb");
    std::mt19937_64 random(3);
    std::vector<double> sizes{kInfinity, 5e-324, 1.7976931348623157e308, 0.1};
    while (sizes.size() < 500) sizes.push_back(std::abs(support::any_double(random)) + 5e-324);
    write_sizes(folder / name, sizes);
    CHECK(read_sizes(folder / name, sizes.size()) == sizes);
    CHECK_THROWS_WITH(read_sizes(folder / name, 499), Catch::Contains("500 sizes, but 499"));
    for (const double bad : {0.0, -1.0, std::nan("")})
        CHECK_THROWS_AS(write_sizes(folder / name, std::vector{bad}), std::invalid_argument);
    write_sizes(folder / name, {});
    CHECK(read_sizes(folder / name, 0).empty());
}

TEST_CASE("a soup without triangles or points is written and read", "[io]") {
    const TemporaryFolder folder;
    const std::string name = GENERATE("a.mesh", "a.meshb", "a.msh", "a.off", "a.ply", "a.stl", "a.vtu");
    write_mesh(folder / name, {});
    CHECK(read_mesh(folder / name).triangles.empty());
}

TEST_CASE("what no reader would take is not written", "[io]") {
    const TemporaryFolder folder;
    const auto refused = [&](auto&& spoil) {
        TriangleSoup soup = wild_soup(1);
        spoil(soup);
        CHECK_THROWS_AS(write_mesh(folder / "a.mesh", soup), std::invalid_argument);
    };
    refused([](TriangleSoup& s) { s.points[3].z() = kInfinity; });
    refused([](TriangleSoup& s) { s.triangles[5][1] = 60; });
    refused([](TriangleSoup& s) { s.labels.pop_back(); });
    refused([](TriangleSoup& s) { s.edges[0][0] = -1; });
    refused([](TriangleSoup& s) { s.corners[0] = 99; });
    refused([](TriangleSoup& s) { s.required.vertices[0] = 60; });
    refused([](TriangleSoup& s) { s.required.edges[1][1] = -1; });
    refused([](TriangleSoup& s) { s.required.triangles[0] = 100; });
    refused([](TriangleSoup& s) { s.parameters[0].vertex = 60; });
    CHECK_THROWS_WITH(write_mesh(folder / "a.xyz", {}), Catch::Contains(".xyz"));
    CHECK_THROWS_WITH(write_mesh(folder / "a.vtp", {}), Catch::Contains("only read"));
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("Medit files of other tools are read", "[io]") {
    const TemporaryFolder folder;
    SECTION("comments, keywords and counts on one line, signs, Fortran exponents, unknown sections, quadrilaterals") {
        const TriangleSoup soup = read_text(folder, "a.mesh",
                                            "\xEF\xBB\xBF# by hand\r\n MeshVersionFormatted 1 Dimension 3\r\n"
                                            "Geometry \"some file.mesh\"\nAngleOfCornerBound 30.5\n"
                                            "Triangles 1 1 2 3 7 # before the vertices\n"
                                            "Normals\n2\n0 0 1\nnan inf 0\n"
                                            "Vertices 4  0 0 0 1  +1.0D0 0 0 1\n1e0 10d-1 0 1 0 1. 0 1\n"
                                            "Quadrilaterals\n1\n1 2 3 4 9\nEdges 2 1 2 0 2 3 0 RequiredEdges 1 2 "
                                            "Ridges 1 1 Corners 1 4\nEnd\nleft over");
        CHECK(soup.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
        CHECK(soup.labels == std::vector{7, 9, 9});
        CHECK(soup.points[2] == Eigen::Vector3d(1, 1, 0));
        CHECK(soup.edges == std::vector<std::array<int, 2>>{{0, 1}});
        CHECK(soup.required.edges == std::vector<std::array<int, 2>>{{1, 2}});
        CHECK(soup.corners == std::vector{3});
    }
    SECTION("required elements: edges that are ridges too stay features, triangles are counted in their own sections") {
        const TriangleSoup soup = read_text(
            folder, "a.mesh",
            "MeshVersionFormatted 2 Dimension 3 RequiredTriangles 2 3 1 RequiredVertices 2 4 1 RequiredEdges 2 3 1\n"
            "Vertices 5 0 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 2 0 0 0\nQuadrilaterals 1 1 2 3 4 0\nTriangles 1 2 5 3 0\n"
            "Quadrilaterals 1 1 2 3 4 0\nTriangles 2 1 2 3 0 1 3 4 0\nEdges 3 1 2 0 2 3 0 3 4 0\nRidges 2 1 2\nEnd\n");
        REQUIRE(soup.triangles.size() == 7);
        CHECK(soup.required.triangles == std::vector{6, 2});
        CHECK(soup.triangles[6] == Triangle{0, 2, 3});
        CHECK(soup.triangles[2] == Triangle{1, 4, 2});
        CHECK(soup.required.vertices == std::vector{3, 0});
        CHECK(soup.required.edges == std::vector<std::array<int, 2>>{{2, 3}, {0, 1}});
        CHECK(soup.edges == std::vector<std::array<int, 2>>{{0, 1}, {1, 2}});
    }
    SECTION("a planar mesh") {
        const TriangleSoup soup = read_text(
            folder, "a.mesh",
            "MeshVersionFormatted 2\n\nDimension\n2\nVertices\n3\n0 0 0\n1 0 0\n1 2.5 0\nTriangles\n1\n1 2 3 0\n");
        CHECK(soup.points[2] == Eigen::Vector3d(1, 2.5, 0));
        CHECK(soup.labels.empty());
    }
    SECTION("sizes with counts on the line of the keyword") {
        support::spill(folder / "a.sol", "MeshVersionFormatted 2 Dimension 3 SolAtVertices 3 1 1 1 inf 2.5d-1 End");
        CHECK(read_sizes(folder / "a.sol", 3) == std::vector{1.0, kInfinity, 0.25});
    }
    SECTION("binary of all versions and both byte orders, with an unknown section") {
        const int version = GENERATE(1, 2, 3, 4);
        const bool big = GENERATE(false, true);
        const TriangleSoup soup = read_text(folder, "a.meshb", support::binary_medit(version, big));
        CHECK(soup.triangles == kTwo);
        CHECK(soup.labels == std::vector{6, 6});
        CHECK(soup.points[3] == Eigen::Vector3d(0, 1, 0.5));
    }
}

TEST_CASE("OBJ in all its spellings is read", "[io]") {
    const TemporaryFolder folder;
    const TriangleSoup soup = read_text(
        folder, "a.obj",
        "# comment \\\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 .5 .5 .5 # colour\r\nv 0 \\\n 1 0\n"
        "vt 0 0\nvn 0 0 1\nvp 1\ng a b\nusemtl m\ns off\n"
        "f 1 2 3 4\nf 1/1 2/1 3/1\nf 1//1 2//1 \\\n3//1\nf 1/1/1 2/1/1 3/1/1\r\nf -4 -3 -2#x\n  f\t+1 2/ 3\nl 1 2\nf 5 "
        "6 7\n"
        "v 2 0 0\nv 3 0 0\nv 3 1 0");
    CHECK(soup.points.size() == 7);
    CHECK(soup.points[3] == Eigen::Vector3d(0, 1, 0));
    const Triangle t{0, 1, 2};
    CHECK(soup.triangles == std::vector<Triangle>{t, {0, 2, 3}, t, t, t, t, t, {4, 5, 6}});
}

TEST_CASE("OFF in all its spellings is read", "[io]") {
    const TemporaryFolder folder;
    const std::string text =
        GENERATE("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
                 "OFF 4 1 0 # counts here\n\n0 0 0\n\n1 0 0 # a\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n\n",
                 "4 1 4\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n4 0 1 2 3\r\n",
                 "# x\nOFF\n# y\n4 1\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 .5 .5 .5 1",
                 "COFF\n4 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n1 1 0 0 0 0 0\n0 1 0 1 1 1 1\n4 0 1 2 3\n",
                 "NOFF\n4 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n",
                 "STCNOFF\n4 1 0\n0 0 0 0 0 1 1 1 1 1 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
    const TriangleSoup soup = read_text(folder, "a.off", text);
    CHECK(soup.triangles == kTwo);
    CHECK(soup.points[2] == Eigen::Vector3d(1, 1, 0));
}

TEST_CASE("PLY with any properties in any order is read", "[io]") {
    const TemporaryFolder folder;
    SECTION("text") {
        const TriangleSoup soup = read_text(folder, "a.ply",
                                            "ply\r\nformat ascii 1.0\r\ncomment property list\r\nobj_info x\r\nelement "
                                            "extra 2\r\nproperty list uchar float odd\r\n"
                                            "element face 1\r\nproperty uchar red\r\nproperty list uchar uint "
                                            "vertex_index\r\nproperty list int8 int16 more\r\n"
                                            "element vertex 4\r\nproperty float z\r\nproperty uchar red\r\nproperty "
                                            "float32 y\r\nproperty double x\r\nelement none 0\r\n"
                                            "property int a\r\nend_header\r\n0\r\n2 1.5 nan\r\n255 4 0 1 2 3 2 7 "
                                            "8\r\n0 9 0 0\r\n0 9 0 1\r\n0 9 1 1\r\n0.1 9 1 0\r\n");
        CHECK(soup.triangles == kTwo);
        CHECK(soup.points[3] == Eigen::Vector3d(0, 1, 0.1));
    }
    SECTION("binary of both byte orders") {
        const bool big = GENERATE(false, true);
        std::string bytes =
            std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
            " 1.0\nelement vertex 4\nproperty short x\nproperty float y\nproperty char s\nproperty float64 z\n"
            "element face 1\nproperty list ushort short vertex_indices\nproperty double q\nelement tail 1\nproperty "
            "list "
            "int char c\nend_header\n";
        const double xyz[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.1}};
        for (const auto& [x, y, z] : xyz) {
            put(bytes, std::int16_t(x), big);
            put(bytes, float(y), big);
            put(bytes, std::int8_t{-1}, big);
            put(bytes, z, big);
        }
        put(bytes, std::uint16_t{4}, big);
        for (std::int16_t k = 0; k < 4; ++k) put(bytes, k, big);
        put(bytes, 1.0, big);
        put(bytes, std::int32_t{3}, big);
        bytes += "abc";
        const TriangleSoup soup = read_text(folder, "a.ply", bytes);
        CHECK(soup.triangles == kTwo);
        CHECK(soup.points[3] == Eigen::Vector3d(0, 1, 0.1));
    }
}

TEST_CASE("scalar properties of PLY are fields", "[io]") {
    const TemporaryFolder folder;
    support::spill(folder / "a.ply",
                   "ply\nformat ascii 1.0\nelement face 2\nproperty uchar material\nproperty list uchar int "
                   "vertex_indices\nproperty double area\n"
                   "element vertex 5\nproperty float x\nproperty float size\nproperty float y\nproperty float "
                   "z\nproperty list uchar int rings\n"
                   "property uint id\nend_header\n7 4 0 1 2 3 1\n8 3 0 3 4 nan\n"
                   "0 1.5 0 0 0 10\n1 inf 0 0 1 5 11\n1 nan 1 0 0 12\n0 2.5 1 0 0 4294967295\n-1 3 1 0 0 14\n");
    const MeshData data = read_mesh_data(folder / "a.ply");
    REQUIRE(data.point_fields.size() == 2);
    CHECK(data.point_fields[0].name == "size");
    CHECK(data.point_fields[0].components == 1);
    REQUIRE(data.point_fields[0].values.size() == 5);
    CHECK(data.point_fields[0].values[1] == kInfinity);
    CHECK(std::isnan(data.point_fields[0].values[2]));
    CHECK(data.point_fields[1].values == std::vector{10.0, 11.0, 12.0, 4294967295.0, 14.0});
    REQUIRE(data.cell_fields.size() == 2);
    CHECK(data.cell_fields[0].name == "material");
    CHECK(data.cell_fields[0].values == std::vector{7.0, 7.0, 8.0});  // the quadrilateral became two
    CHECK(data.cell_fields[1].values[1] == 1);
    CHECK(std::isnan(data.cell_fields[1].values[2]));
    CHECK(data.soup.triangles == read_mesh(folder / "a.ply").triangles);
}

TEST_CASE("STL is welded where coordinates are equal", "[io]") {
    const TemporaryFolder folder;
    const TriangleSoup soup = read_text(
        folder, "a.stl",
        "solid a name of\tmany words\n FACET NORMAL nan nan nan\n OUTER LOOP\nvertex 0 0 0\nvertex 1 0 0\nvertex 1e0 1 "
        "0\n"
        "endloop\nendfacet\nendsolid a name\nsolid\nfacet normal 0 0 1\nouter loop vertex -0 0 0 vertex 1 1 0\n"
        "vertex 0 1 1e-300\nendloop endfacet\nendsolid");
    CHECK(soup.triangles == kTwo);
    CHECK(diagnose(soup).components == 1);
}

TEST_CASE("a text of numbers is read exactly rounded", "[io][exact]") {
    const TemporaryFolder folder;
    const TriangleSoup soup =
        read_text(folder, "a.obj",
                  "v 0.1000000000000000055511151231257827021181583404541015625 9007199254740993 1e-400\n"
                  "v -1e-4000 2.2250738585072011e-308 179769313486231570000000000000000000000000000000000000000e252\n");
    CHECK(soup.points[0] == Eigen::Vector3d(0.1, 9007199254740992.0, 0));
    CHECK(soup.points[1] == Eigen::Vector3d(0, 2.2250738585072011e-308, 1.7976931348623157e308));
    std::string long_fortran = "0.";
    long_fortran.append(2000, '0').append("1d2001");
    CHECK(read_text(folder, "a.obj", "v " + long_fortran + " 0 0\n").points[0] == Eigen::Vector3d(1, 0, 0));
}

namespace {

struct Malformed {
    const char* name;
    const char* start;  ///< well formed, then
    const char* rest;
    int line;
    const char* says;
};

#define GRADUS_PLY "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
constexpr const char* kMesh = "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n0 1 0 0\n";
constexpr const char* kPly = GRADUS_PLY;
constexpr const char* kPlyFaces = GRADUS_PLY "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
constexpr const char* kSolid = "solid\nfacet normal 0 0 1\nouter loop\n";
constexpr const char* kSol = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n";

constexpr Malformed kMalformed[] = {
    {"a.mesh", "", "", 0, "empty"},
    {"a.obj", "", "\xFE\xFFv", 1, "UTF-16"},
    {"a.off", "", "\xFF\xFEO", 1, "UTF-16"},
    {"a.mesh", "", "solid", 1, "MeshVersionFormatted"},
    {"a.mesh", "", "MeshVersionFormatted 9\n", 1, "version"},
    {"a.mesh", "", "MeshVersionFormatted 2\nDimension 4\n", 2, "dimension"},
    {"a.mesh", kMesh, "", 7, "no Triangles"},
    {"a.mesh", "", "MeshVersionFormatted 2\nDimension 3\nTriangles\n0\nEnd\n", 5, "no Vertices"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 4 0\n", 10, "vertex 4; there are 3"},
    {"a.mesh", kMesh, "Triangles\n1\n1 0 2 0\n", 10, "vertex 0"},
    {"a.mesh", kMesh, "Triangles\n2\n1 2 3 0\nEnd\n", 11, "found 'End'"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\n1 2 3 0\nEnd\n", 11, "more entries"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2\n", 10, "end of the file"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2.5 3 0\n", 10, "'2.5'"},
    {"a.mesh", kMesh, "Triangles\n-1\n", 9, "negative"},
    {"a.mesh", kMesh, "Triangles\n1000000000000000000\n1 2 3 0\n", 9, "more than the rest"},
    {"a.mesh", kMesh, "Triangles\n99999999999999999999\n1 2 3 0\n", 9, "'9999"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nEdges\n1\n1 4 0\n", 13, "vertex 4"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nRidges\n1\n1\n", 13, "edge 1; there are 0"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nRequiredTriangles\n1\n2\n", 13, "triangle 2; there are 1"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nRequiredVertices\n1\n0\n", 13, "vertex 0"},
    {"a.mesh", kMesh, "RequiredEdges\n1\n1\nTriangles\n1\n1 2 3 0\n", 10, "edge 1; there are 0"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nCorners\n1\n4\n", 13, "vertex 4"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nVerticesOnGeometricTriangles\n1\n1 1 nan 0 0\n", 13, "not finite"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nEnd\n# VerticesOnGeometricTriangles\n# 1\n# 4 1 0 0 0\n", 14, "vertex 4"},
    {"a.mesh", kMesh, "Triangles\n1\n1 2 3 0\nEnd\n# VerticesOnGeometricTriangles\n# 2\n# 3 1 0 0 0\n", 14,
     "end of the file"},
    {"a.mesh", kMesh, kMesh, 11, "second Vertices"},
    {"a.mesh", "", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 nan 0 0\n", 5, "not finite"},
    {"a.mesh", "", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 1e400 0 0\n", 5, "beyond double"},
    {"a.mesh", "", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0x 0 0\n", 5, "'0x'"},
    {"a.mesh", kSol, "1\n1 1\n1\nEnd\n", 4, "sizes"},
    {"a.obj", "", "# nothing\n", 1, "no vertex"},
    {"a.obj", "", "v 0 0 0\nv 0 1\n", 2, "end of the line"},
    {"a.obj", "", "v 0 0 0\nv 0 1 zero\n", 2, "'zero'"},
    {"a.obj", "", "v 0 0 0\nv 0 1 inf\n", 2, "not finite"},
    {"a.obj", "", "v 0 0 0 red\n", 1, "'red'"},
    {"a.obj", "", "v 0 0 0\nf 1 1\n", 2, "at least 3"},
    {"a.obj", "", "v 0 0 0\n\nf 1 1 2\nv 0 0", 4, "end of the file"},
    {"a.obj", "", "v 0 0 0\n\nf 1 1 2\n", 3, "vertex 2 out of range; there are 1"},
    {"a.obj", "", "v 0 0 0\nf 1 1 0\n", 2, "vertex 0"},
    {"a.obj", "", "v 0 0 0\nf 1 1 -2\n", 2, "vertex -2"},
    {"a.obj", "", "v 0 0 0\nf 1 1 99999999999999999999\n", 2, "out of range"},
    {"a.obj", "", "v 0 0 0\nf 1 \\\n1 a\n", 3, "'a'"},
    {"a.obj", "", "v 0 0 0\nf 1/1/1/1 1 1\n", 2, "vertex of a face"},
    {"a.off", "", "PLY\n", 1, "OFF"},
    {"a.off", "", "nOFF\n3\n", 1, "OFF"},
    {"a.off", "", "OFF BINARY\n", 1, "binary"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0\n1 0 0\n", 4, "end of the file"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", 5, "end of the file"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", 6, "vertex 3"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", 6, "at least 3"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n2\n", 6, "end of the line"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", 7, "after 1 faces"},
    {"a.off", "", "OFF\n3 1 0\n0 0 0 1\n1 0 0\n0 1 0\n3 0 1 2\n", 3, "end of the line"},
    {"a.off", "", "OFF\n1000000000 1 0\n0 0 0\n", 2, "more than the rest"},
    {"a.ply", "", "plx\n", 1, "PLY"},
    {"a.ply", "", "ply\nformat ascii 2.0\n", 2, "1.0"},
    {"a.ply", "", "ply\nformat text 1.0\n", 2, "'text'"},
    {"a.ply", "", "ply\nformat ascii 1.0\nelement vertex 3\nproperty real x\n", 4, "'real'"},
    {"a.ply", "", "ply\nformat ascii 1.0\nproperty float x\n", 3, "unexpected"},
    {"a.ply", kPly, "end_header\n", 7, "no element face"},
    {"a.ply", kPlyFaces, "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", 13, "vertex 3"},
    {"a.ply", kPlyFaces, "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", 13, "vertex -1"},
    {"a.ply", kPlyFaces, "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", 13, "at least 3"},
    {"a.ply", kPlyFaces, "0 0 0\n1 0 0\n0 1 0\n", 12, "end of the file"},
    {"a.ply", kPlyFaces, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n7\n", 14, "end of the file"},
    {"a.ply", kPlyFaces, "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", 11, "not finite"},
    {"a.ply", "", "ply\nformat ascii 1.0\nelement vertex 1000000000000\nproperty float x\n", 3, "more than the rest"},
    {"a.stl", "", "solid\nfacet normal 0 0 1\nouter lop\n", 3, "expected loop"},
    {"a.stl", kSolid, "vertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n", 6, "expected vertex"},
    {"a.stl", kSolid, "vertex 0 0 0\nvertex 1 0 inf\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n", 5, "not finite"},
    {"a.stl", kSolid, "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n", 8, "endsolid"},
    {"a.stl", "", "short", 0, "end of the file"},
    {"a.meshb", "", "abc", 0, "end of the file"},
    {"a.meshb", "", "abcdefgh", 0, "not a binary Medit"},
    {"a.sol", kSol, "2\n1 1\n1\n0\n", 7, "must be > 0"},
    {"a.sol", kSol, "2\n1 1\n1\n-1\n", 7, "must be > 0"},
    {"a.sol", kSol, "2\n1 1\n1\nnan\n", 7, "must be > 0"},
    {"a.sol", kSol, "2\n1 3\n1 1\n", 5, "one scalar"},
    {"a.sol", kSol, "2\n1 1\n1\n", 6, "end of the file"},
    {"a.sol", kSol, "2\n1 1\n1 1 1\n", 6, "more entries"},
    {"a.sol", kSol, "3\n1 1\n1 1 1\n", 4, "holds 3 sizes, but 2"},
    {"a.sol", kSol, "1000000000000\n", 4, "more than the rest"},
    {"a.sol", "", "MeshVersionFormatted 2\nDimension 3\nEnd\n", 3, "no SolAtVertices"},
    {"a.xyz", "", "1 2 3\n", 0, ".xyz"},
};

void check_refused(const TemporaryFolder& folder, const std::string& name, const std::string& contents, int line,
                   const char* says) {
    support::check_refused(folder / name, contents, line, says, [&](const std::string& path) {
        if (name == "a.sol")
            read_sizes(path, 2);
        else
            read_mesh(path);
    });
}

}  // namespace

TEST_CASE("malformed texts are refused with the path and the line", "[io]") {
    const TemporaryFolder folder;
    for (const auto& [name, start, rest, line, says] : kMalformed)
        check_refused(folder, name, std::string(start) + rest, line, says);
}

TEST_CASE("malformed binary files are refused with the path and the byte", "[io]") {
    const TemporaryFolder folder;
    const std::string one("\1\0\0\0", 4), header = std::string(80, ' ') + one;
    check_refused(folder, "a.stl", std::string(84, 'x'), 0, "number of triangles");
    check_refused(folder, "a.stl", header + std::string(49, '\0'), 0, "more than the rest");
    check_refused(folder, "a.stl", header + std::string(51, '\0'), 0, "bytes follow");
    check_refused(folder, "a.meshb", std::string("\1\0\0\0\2\0\0\0\4\0\0\0\0\0\0\0", 16), 0, "ends before it starts");
}

TEST_CASE("missing files and folders are refused", "[io]") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "a.mesh");
    CHECK_THROWS_AS(read_mesh(folder / "a.mesh"), IoError);
    CHECK_THROWS_AS(read_mesh(folder / "b.mesh"), IoError);
    CHECK_THROWS_AS(read_sizes(folder / "b.sol", 1), IoError);
    CHECK_THROWS_AS(read_mesh(folder / "none"), IoError);
}

TEST_CASE("parameters are read as a Medit section and as comments behind its end", "[io]") {
    const TemporaryFolder folder;
    const std::string mesh = std::string(kMesh) + "Triangles\n1\n1 2 3 0\n";
    const auto read = [&](const std::string& rest) {
        write_file(folder / "a.mesh", mesh + rest);
        return read_mesh(folder / "a.mesh").parameters;
    };
    for (const char* rest : {"VerticesOnGeometricTriangles\n1\n3 2 .5 .25 7\nEnd\n",
                             "End\n\n# VerticesOnGeometricTriangles\n# 1\n# 3 2 .5 .25 7\n",
                             "End\n#VerticesOnGeometricTriangles 1\r\n#3 2 .5\n# .25 7",
                             "End\nVerticesOnGeometricTriangles\n1\n3 2 .5 .25 7\nEnd\n"}) {
        INFO(rest);
        const auto parameters = read(rest);
        REQUIRE(parameters.size() == 1);
        CHECK(parameters[0].vertex == 2);
        CHECK(parameters[0].at.patch == 1);
        CHECK(parameters[0].at.uv == Eigen::Vector2d(.5, .25));
    }
    for (const char* rest : {"End\n# made by hand\n", "End\nVertices\n1\n", "End\n# 3 4\n",
                             "# VerticesOnGeometricTriangles\n# 1\nEnd\n"}) {
        INFO(rest);
        CHECK(read(rest).empty());
    }
}

TEST_CASE("faces that are concave polygons have the area of the polygon, convex ones are fans", "[exact]") {
    const support::TemporaryFolder folder;
    const std::string corners = "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n";
    support::spill(folder / "l.off", "OFF\n6 1 0\n" + corners + "6 2 3 4 5 0 1\n");
    support::spill(folder / "l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\n");
    support::spill(folder / "l.ply",
                   "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n"
                   "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                       corners + "6 1 2 3 4 5 0\n");
    for (const std::string name : {"l.off", "l.obj", "l.ply"}) {
        CAPTURE(name);
        const TriangleSoup soup = read_mesh(folder / name);
        REQUIRE(soup.triangles.size() == 4);
        double area = 0;
        for (const Triangle& t : soup.triangles) {
            const double part =
                (soup.points[t[1]] - soup.points[t[0]]).cross(soup.points[t[2]] - soup.points[t[0]]).z() / 2;
            CHECK(part > 0);
            area += part;
        }
        CHECK(area == Approx(3));
    }
    support::spill(folder / "square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    CHECK(read_mesh(folder / "square.obj").triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
    support::spill(folder / "bow.obj", "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 1 0\nf 1 3 2 4\n");
    CHECK_THROWS_WITH(read_mesh(folder / "bow.obj"),
                      Catch::Contains("bow.obj: the face with the vertices 0 2 1 3 (counted from 0) crosses itself"));
    // Folded over, seen along its normal: no crossing.
    support::spill(folder / "folded.obj", "v 0 0 0\nv 1 0 0.1\nv 0.2 0.2 1\nv 0 1 0.1\nf 1 2 3 4\n");
    CHECK(read_mesh(folder / "folded.obj").triangles.size() == 2);
}
