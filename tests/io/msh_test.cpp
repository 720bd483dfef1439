#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numeric>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/damage.hpp"
#include "support/files.hpp"
#include "support/msh_files.hpp"
#include "support/soups.hpp"

using namespace gradus;
using support::binary_msh;
using support::put;
using support::TemporaryFolder;

namespace {

MeshData read_text(const TemporaryFolder& folder, std::string_view text) {
    support::spill(folder / "a.msh", text);
    return read_mesh_data(folder / "a.msh");
}

/// Triangles in the order of their labels, as they are written.
TriangleSoup ordered_by_label(const TriangleSoup& soup) {
    std::vector<std::size_t> order(soup.triangles.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return soup.labels[a] < soup.labels[b]; });
    TriangleSoup result = soup;
    for (std::size_t i = 0; i < order.size(); ++i) {
        result.triangles[i] = soup.triangles[order[i]];
        result.labels[i] = soup.labels[order[i]];
    }
    return result;
}

}  // namespace

TEST_CASE("Gmsh files give back the same bits, triangles in the order of labels", "[io][msh][property]") {
    const TemporaryFolder folder;
    const unsigned seed = GENERATE(range(0u, 8u));
    TriangleSoup soup = support::wild_soup(seed);
    if (seed % 2 == 1)
        for (int& label : soup.labels) label -= 3;  // 0 and negative labels, too
    write_mesh(folder / "a.msh", soup);
    const TriangleSoup back = read_mesh(folder / "a.msh"), expected = ordered_by_label(soup);
    CHECK(support::same_points(soup, back));
    CHECK(back.triangles == expected.triangles);
    CHECK(back.labels == expected.labels);
    CHECK(back.edges == soup.edges);
    soup.labels.clear();
    write_mesh(folder / "a.msh", soup);
    CHECK(read_mesh(folder / "a.msh").triangles == soup.triangles);
    CHECK(read_mesh(folder / "a.msh").labels.empty());
}

TEST_CASE("binary Gmsh files of both versions and byte orders are read, with their fields", "[io][msh]") {
    const TemporaryFolder folder;
    const int version = GENERATE(2, 4);
    const bool big = GENERATE(false, true);
    CAPTURE(version, big);
    const MeshData data = read_text(folder, binary_msh(version, big));
    CHECK(data.soup.points.size() == 6);
    CHECK(data.soup.points[2] == Eigen::Vector3d(1, 1, 0.1));
    CHECK(data.soup.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}});
    CHECK(data.soup.labels == std::vector{5, 5, 2, 2});
    CHECK(data.soup.edges == std::vector<std::array<int, 2>>{{0, 1}});
    REQUIRE(data.point_fields.size() == 1);
    CHECK(data.point_fields[0].name == "size");
    CHECK(data.point_fields[0].values[0] == 0.1);
    CHECK(std::isnan(data.point_fields[0].values[1]));
    CHECK(data.point_fields[0].values[2] == 0.75);
    REQUIRE(data.cell_fields.size() == 1);
    CHECK(data.cell_fields[0].components == 3);
    REQUIRE(data.cell_fields[0].values.size() == 12);
    CHECK(std::isnan(data.cell_fields[0].values[0]));
    CHECK(std::vector(data.cell_fields[0].values.begin() + 6, data.cell_fields[0].values.end()) ==
          std::vector{1.0, 2.0, 3.0, 1.0, 2.0, 3.0});
    CHECK(read_mesh(folder / "a.msh").triangles == data.soup.triangles);
}

namespace {

constexpr const char* kHead2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
constexpr const char* kHead4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
constexpr const char* kNodes2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n";  // 10 lines
// 13 lines
constexpr const char* kNodes4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n";
constexpr const char* kMesh2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 1 1 0\n$EndNodes\n$Elements\n1\n1 2 0 1 2 "
    "3\n$EndElements\n";  // 13

}  // namespace

TEST_CASE("Gmsh's elements of second order give their corners", "[io][msh]") {
    const TemporaryFolder folder;
    const MeshData data = read_text(
        folder, std::string(kHead2) +
                    "$PhysicalNames\n1\n2 5 \"a name\"\n$EndPhysicalNames\n$Nodes\n12\n1 0 0 0\n9 .5 0 0\n2 1 0 0\n3 1 "
                    "1 0\n4 0 1 0\n"
                    "5 1 .5 0\n6 .5 .5 0\n7 .5 1 0\n8 0 .5 0\n10 2 0 0\n11 7 7 7\n12 .2 .2 0\n$EndNodes\n$Elements\n5\n"
                    "1 15 2 0 1 11\n2 8 2 0 1 1 2 9\n3 9 3 0 4 0 1 2 3 9 5 6\n4 16 2 0 4 1 2 3 4 9 5 7 8\n5 10 2 0 4 1 "
                    "2 3 4 9 5 7 8 12\n"
                    "$EndElements\n$NodeData\n1\n\"x\"\n0\n3\n0\n1\n3\n1 1\n4 4\n11 11\n$EndNodeData\n");
    REQUIRE(data.soup.points.size() == 6);  // corners, a node of its own, and one that nothing uses
    CHECK(data.soup.points[1] == Eigen::Vector3d(1, 0, 0));
    CHECK(data.soup.points[5] == Eigen::Vector3d(7, 7, 7));
    CHECK(data.soup.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}});
    CHECK(data.soup.edges == std::vector<std::array<int, 2>>{{0, 1}});
    CHECK(data.soup.labels.empty());  // one entity, no group
    REQUIRE(data.point_fields.size() == 1);
    CHECK(data.point_fields[0].values[3] == 4);
    CHECK(data.point_fields[0].values[5] == 11);
}

TEST_CASE("a later step of a Gmsh field replaces an earlier one", "[io][msh]") {
    const TemporaryFolder folder;
    const auto step = [](int number, const char* value) {
        return fmt::format("$ElementData\n1\n\"q\"\n1\n0\n3\n{}\n1\n1\n1 {}\n$EndElementData\n", number, value);
    };
    const MeshData data = read_text(folder, kMesh2 + step(0, "3") + step(1, "inf"));
    REQUIRE(data.cell_fields.size() == 1);
    CHECK(data.cell_fields[0].values == std::vector{std::numeric_limits<double>::infinity()});
}

TEST_CASE("parts of a Gmsh surface have the label of the whole", "[io][msh]") {
    const TemporaryFolder folder;
    std::string text = kHead4;
    text +=
        "$Entities\n0 0 2 0\n1 0 0 0 1 1 0 1 9 0\n2 0 0 0 1 1 0 0 0\n$EndEntities\n$PartitionedEntities\n2\n1\n50 1\n"
        "0 1 2 0\n3 2 1 2 1 2 0 0 0 1 1 0 0 0\n4 2 1 1 1 0 0 0 1 1 0 1 9 2 3 -1\n5 2 2 1 2 0 0 0 1 1 0 0 0\n"
        "$EndPartitionedEntities\n$Nodes\n1 3 1 3\n2 4 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n"
        "$Elements\n2 2 1 2\n2 4 2 1\n1 1 2 3\n2 5 2 1\n2 1 3 2\n$EndElements\n";
    const MeshData data = read_text(folder, text);
    CHECK(data.soup.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}});
    CHECK(data.soup.labels == std::vector{9, 2});
}

TEST_CASE("malformed Gmsh texts are refused with the path and the line", "[io][msh]") {
    struct Case {
        const char* start;  ///< well formed, then
        const char* rest;
        int line;
        const char* says;
    };
    const Case cases[] = {
        {"", "", 0, "empty"},
        {"", "solid\n", 1, "not a Gmsh file"},
        {"", "$MeshFormat\n1 0 8\n", 2, "version 1"},
        {"", "$MeshFormat\n4 0 8\n", 2, "version 4 of"},
        {"", "$MeshFormat\n2.2 2 8\n", 2, "0 for text or 1"},
        {"", "$MeshFormat\n2.2 0 4\n", 2, "4 bytes"},
        {"", "$MeshFormat\n2.2 0 8\n$Nodes\n", 3, "$EndMeshFormat, found '$Nodes'"},
        {kHead2, "", 3, "no $Nodes"},
        {kHead2, "$Elements\n0\n$EndElements\n", 4, "before $Nodes"},
        {kHead2, "1 2 3\n", 4, "start of a section"},
        {kHead2, "$Nodes\n3\n1 0 0 0\n2 0 0\n3 1 1 0\n$EndNodes\n", 9, "a coordinate, found '$EndNodes'"},
        {kHead2, "$Nodes\n2\n1 0 0 0\n2 0 nan 0\n$EndNodes\n", 7, "not finite"},
        {kHead2, "$Nodes\n2\n1 0 0 0\n2 0 x 0\n$EndNodes\n", 7, "'x'"},
        {kHead2, "$Nodes\n2\n1 0 0 0\n1 0 1 0\n$EndNodes\n", 4, "node 1 comes twice"},
        {kHead2,
         "$Nodes\n2\n2147483648 0 0 0\n9223372036854775807 0 1 0\n$EndNodes\n$Elements\n1\n1 2 0 1 2 3\n$EndElements\n",
         11, "node 1 is not among"},
        {kHead2, "$Nodes\n2\n9223372036854775807 0 0 0\n1 0 1 0\n$EndNodes\n$Elements\n1\n1 2 0 1 2 3\n$EndElements\n",
         11, "node 2 is not among"},
        {kHead2, "$Nodes\n1\n-1 0 0 0\n$EndNodes\n", 6, "negative"},
        {kHead2, "$Nodes\n1000000000\n1 0 0 0\n$EndNodes\n", 5, "more than the rest"},
        {kHead2, "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n", 7, "$EndNodes, found '2'"},
        {kNodes2, "$Nodes\n0\n$EndNodes\n", 11, "a second $Nodes"},
        {kNodes2, "", 10, "no $Elements"},
        {kNodes2, "$Comments\n", 11, "no $EndComments"},
        {kNodes2, "$Elements\n1\n1 2 2 0 1 1 2 5\n$EndElements\n", 13, "node 5 is not"},
        {kNodes2, "$Elements\n1\n1 2 2 0 1 1 2\n$EndElements\n", 14, "found '$EndElements'"},
        {kNodes2, "$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n", 13, "holds tetrahedra; give a surface mesh"},
        {kNodes2, "$Elements\n1\n1 5 2 0 1 1 2 3 4 1 2 3 4\n$EndElements\n", 13, "holds hexahedra"},
        {kNodes2, "$Elements\n1\n1 999 2 0 1 1 2 3\n$EndElements\n", 13, "type 999"},
        {kNodes2, "$Elements\n1\n1 2 -1 1 2 3\n$EndElements\n", 13, "tags is negative"},
        {kNodes2, "$Elements\n1\n1 2 1 99999999999 1 2 3\n$EndElements\n", 13, "a tag is out of range"},
        {kNodes2, "$Elements\n900000000\n1 2 0 1 2 3\n$EndElements\n", 12, "more than the rest"},
        {kNodes4, "$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 4\n$EndElements\n", 17, "node 4 is not"},
        {kNodes4, "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 1\n$EndElements\n", 16, "holds tetrahedra"},
        {kNodes4, "$Elements\n1 2 1 2\n2 1 2 1\n1 1 2 3\n$EndElements\n", 15,
         "2 elements are announced, but the blocks hold 1"},
        {kNodes4, "$Elements\n1 1 1 1\n2 1 2 1000000000\n1 1 2 3\n$EndElements\n", 16, "more than the rest"},
        {kNodes4, "$Elements\n2 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n", 18, "found '$EndElements'"},
        {kHead4, "$Nodes\n1 3 1 3\n2 1 0 1\n1\n0 0 0\n$EndNodes\n", 5, "3 nodes are announced, but the blocks hold 1"},
        {kHead4, "$Nodes\n1 1 1 1\n4 1 0 1\n1\n0 0 0\n$EndNodes\n", 6, "dimension of an entity is 4"},
        {kHead4, "$PartitionedEntities\n2\n1000000000\n$EndPartitionedEntities\n", 6, "more than the rest"},
        {kHead4, "$Entities\n0 0 1000000000 0\n$EndEntities\n", 5, "more than the rest"},
        {kMesh2, "$NodeData\n1\n\"x\"\n0\n3\n0\n1\n1\n4 1\n$EndNodeData\n", 22, "for 4, which is not in the mesh"},
        {kMesh2, "$NodeData\n1\n\"x\"\n0\n3\n0\n1\n2\n1 1\n$EndNodeData\n", 23, "found '$EndNodeData'"},
        {kMesh2, "$NodeData\n1\n\"x\"\n0\n3\n0\n1000000000\n1\n1 1\n$EndNodeData\n", 18, "components is 1000000000"},
        {kMesh2, "$NodeData\n1\n\"x\"\n0\n3\n0\n1\n1000000000\n1 1\n$EndNodeData\n", 21, "more than the rest"},
        {kMesh2, "$NodeData\n1\n\"x\"\n0\n1\n0\n$EndNodeData\n", 18, "number of components"},
    };
    const TemporaryFolder folder;
    for (const auto& [start, rest, line, says] : cases)
        support::check_refused(folder / "a.msh", std::string(start) + rest, line, says,
                               [](const std::string& path) { read_mesh_data(path); });
}

TEST_CASE("malformed binary Gmsh files are refused with the path and the byte", "[io][msh]") {
    const TemporaryFolder folder;
    const int version = GENERATE(2, 4);
    const std::string valid = binary_msh(version, false);
    const auto check = [&](const std::string& contents, const char* says) {
        support::check_refused(folder / "a.msh", contents, 0, says,
                               [](const std::string& path) { read_mesh_data(path); });
    };
    std::string spoilt = valid;
    spoilt[valid.find(" 1 8\n") + 5] = 3;
    check(spoilt, "byte order");
    spoilt = valid;
    const std::size_t nodes = valid.find("$Nodes\n");
    const std::size_t x = nodes + (version == 2 ? 7 + 2 + 4 : 7 + 32 + 12 + 8 + 32);
    const double nan = std::nan("");
    std::memcpy(spoilt.data() + x, &nan, 8);
    check(spoilt, "a coordinate is not finite");
    check(valid.substr(0, valid.find("$EndNodes") - 20), version == 2 ? "end of the file" : "more than the rest");
    check(valid.substr(0, valid.find("$EndElements") - 4), "end of the file");
}
