// Fields in files: written and read back, and read from solutions.
#include <bit>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "gradus/io/error.hpp"
#include "gradus/io/mesh_files.hpp"
#include "support/files.hpp"
#include "support/soups.hpp"

using namespace gradus;
using support::TemporaryFolder;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// All components and any values, some missing.
Field some(const std::string& name, int components, std::size_t count, bool integer = false) {
    Field field{name, components, {}, integer};
    for (std::size_t i = 0; i < count * static_cast<std::size_t>(components); ++i)
        field.values.push_back(integer ? static_cast<double>(i * 7919 % 1000) - 500
                                       : std::sin(static_cast<double>(i)) / 3);
    if (!integer) field.values[1] = std::nan(""), field.values[2] = kInfinity;
    return field;
}

MeshData rich() {
    MeshData data{support::grid(6)};
    const std::size_t n = data.soup.points.size(), m = data.soup.triangles.size();
    for (std::size_t t = 0; t < m; ++t) data.soup.labels.push_back(4 + static_cast<int>(3 * t / m));
    data.point_fields = {some("T", 1, n), some("flow", 3, n), some("stress tensor", 6, n), some("flow_1", 1, n),
                         some("pair", 2, n)};
    data.cell_fields = {some("material", 1, m, true), some("q \u00b5 <&>", 4, m), some("x", 1, m)};
    return data;
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void check_same(const std::vector<Field>& fields, const std::vector<Field>& expected) {
    REQUIRE(fields.size() == expected.size());
    for (std::size_t i = 0; i < fields.size(); ++i) {
        CAPTURE(expected[i].name);
        CHECK(fields[i].name == expected[i].name);
        CHECK(fields[i].components == expected[i].components);
        CHECK(std::equal(fields[i].values.begin(), fields[i].values.end(), expected[i].values.begin(),
                         expected[i].values.end(), same));
    }
}

std::vector<Field> without_labels(std::vector<Field> fields) {
    std::erase_if(fields, [](const Field& field) { return field.name == "label"; });
    return fields;
}

}  // namespace

TEST_CASE("fields come back from files with their names, components and values", "[io][property]") {
    const TemporaryFolder folder;
    const MeshData data = rich();
    const std::string name = GENERATE("a.vtu", "a.ply", "a.msh");
    const bool ascii = GENERATE(false, true);
    CAPTURE(name, ascii);
    REQUIRE(holds_fields(name));
    write_mesh_data(folder / name, data, {.ascii = ascii});
    const MeshData back = read_mesh_data(folder / name);
    CHECK(back.soup.points == data.soup.points);
    CHECK(back.soup.triangles == data.soup.triangles);
    CHECK(back.soup.labels == data.soup.labels);
    check_same(back.point_fields, data.point_fields);
    check_same(without_labels(back.cell_fields), data.cell_fields);
    // Again, from what was read: nothing is added.
    write_mesh_data(folder / name, back, {.ascii = ascii});
    check_same(read_mesh_data(folder / name).point_fields, data.point_fields);
    check_same(without_labels(read_mesh_data(folder / name).cell_fields), data.cell_fields);
    CHECK(read_mesh(folder / name).labels == data.soup.labels);
}

TEST_CASE("integers stay integers, and say so where the format can", "[io]") {
    const TemporaryFolder folder;
    const std::string name = GENERATE("a.vtu", "a.ply");
    MeshData data = rich();
    data.cell_fields = {some("small", 1, data.soup.triangles.size(), true),
                        some("large", 1, data.soup.triangles.size(), true)};
    for (double& x : data.cell_fields[0].values) x = std::abs(x) / 2 - std::fmod(std::abs(x), 2) / 2;
    for (double& x : data.cell_fields[1].values) x = 1e6 * x + 1;
    write_mesh_data(folder / name, data, {.ascii = GENERATE(false, true)});
    const MeshData back = read_mesh_data(folder / name);
    check_same(without_labels(back.cell_fields), data.cell_fields);
    for (const Field& field : back.cell_fields) CHECK(field.integer);
    for (const Field& field : back.point_fields) CHECK_FALSE(field.integer);
    // What is no integer after all is not made one.
    data.cell_fields[0].values[3] = 0.5;
    write_mesh_data(folder / name, data);
    CHECK(without_labels(read_mesh_data(folder / name).cell_fields)[0].values[3] == 0.5);
}

TEST_CASE("feature edges have no values, and take none from triangles", "[io]") {
    const TemporaryFolder folder;
    const std::string name = GENERATE("a.vtu", "a.msh");
    MeshData data = rich();
    data.soup.edges = {{0, 1}, {1, 2}, {2, 3}};
    write_mesh_data(folder / name, data);
    const MeshData back = read_mesh_data(folder / name);
    CHECK(back.soup.edges == data.soup.edges);
    CHECK(back.soup.labels == data.soup.labels);
    check_same(without_labels(back.cell_fields), data.cell_fields);
}

TEST_CASE("properties of PLY are words, and colours are bytes", "[io]") {
    const TemporaryFolder folder;
    MeshData data{support::tetrahedron()};
    data.point_fields = {{"red", 1, {0, 255, 128, 7}, true}, {"x", 1, {1, 2, 3, 4}}, {"two words", 1, {1, 2, 3, 4}}};
    write_mesh_data(folder / "a.ply", data, {.ascii = true});
    const std::string text = gradus::read_mesh(folder / "a.ply").points.empty() ? "" : [&] {
        std::ifstream in(folder / "a.ply");
        return std::string(std::istreambuf_iterator<char>(in), {});
    }();
    CHECK_THAT(text, Catch::Contains("property uchar red\n") && Catch::Contains("property double x_\n") &&
                         Catch::Contains("property double two_words\n"));
    CHECK_THAT(text, Catch::Contains("comment gradus field 1 two words\n"));
    check_same(read_mesh_data(folder / "a.ply").point_fields, data.point_fields);
}

TEST_CASE("a comment that promises more components than there are is only a comment", "[io]") {
    const TemporaryFolder folder;
    const std::string comment = GENERATE("gradus field 3 v", "gradus field 0 v", "gradus field -1 v",
                                         "gradus field 99999999999999999999 v", "gradus field 2", "gradus field 2 ");
    CAPTURE(comment);
    support::spill(
        folder / "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\ncomment " +
            comment +
            "\nproperty float a\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 1 2\n1 0 0 3 4\n0 1 0 5 6\n3 0 1 2\n");
    const MeshData data = read_mesh_data(folder / "a.ply");
    REQUIRE(data.point_fields.size() == 2);
    CHECK(data.point_fields[1].name == "b");
    CHECK(data.point_fields[1].values == std::vector{2.0, 4.0, 6.0});
}

TEST_CASE("formats that hold no fields, and fields that fit nothing, are refused", "[io]") {
    const TemporaryFolder folder;
    MeshData data = rich();
    for (const char* name : {"a.mesh", "a.meshb", "a.obj", "a.off", "a.stl", "a.vtp", "a.sol", "a"})
        CHECK_FALSE(holds_fields(name));
    CHECK_THROWS_AS(write_mesh_data(folder / "a.obj", data), IoError);
    CHECK_THROWS_AS(write_mesh_data(folder / "a.vtp", data), IoError);
    CHECK_FALSE(std::filesystem::exists(folder / "a.obj"));
    write_mesh_data(folder / "a.obj", {data.soup});
    CHECK(read_mesh(folder / "a.obj").triangles == data.soup.triangles);
    data.point_fields.push_back({"T", 1, std::vector<double>(data.soup.points.size())});
    CHECK_THROWS_AS(write_mesh_data(folder / "a.vtu", data), std::invalid_argument);
    data.point_fields.back() = {"short", 1, {1}};
    CHECK_THROWS_AS(write_mesh_data(folder / "a.vtu", data), std::invalid_argument);
    data.point_fields.back() = {"", 1, std::vector<double>(data.soup.points.size())};
    CHECK_THROWS_AS(write_mesh_data(folder / "a.vtu", data), std::invalid_argument);
    data.point_fields = {{"wide", 65, std::vector<double>(65 * data.soup.points.size())}};
    CHECK_THROWS_AS(write_mesh_data(folder / "a.msh", data), IoError);
    write_mesh_data(folder / "a.ply", data);
    check_same(read_mesh_data(folder / "a.ply").point_fields, data.point_fields);
}

TEST_CASE("solutions of any kinds of fields are read", "[io]") {
    const TemporaryFolder folder;
    support::spill(
        folder / "flow.sol",
        "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n2\n4 1 2 3 4\n"
        "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19\n-1 nan 0 0 0 0 0 0 0 inf 0 0 0 0 0 0 0 0 20\nEnd\n");
    const std::vector<Field> fields = read_solution(folder / "flow.sol", 2);
    REQUIRE(fields.size() == 4);
    const int components[] = {1, 3, 6, 9};
    for (int i = 0; i < 4; ++i) {
        CHECK(fields[i].name == "flow_" + std::to_string(i + 1));
        CHECK(fields[i].components == components[i]);
        CHECK(fields[i].values.size() == 2 * static_cast<std::size_t>(components[i]));
    }
    CHECK(fields[0].values == std::vector{1.0, -1.0});
    CHECK(std::isnan(fields[1].values[3]));
    CHECK(fields[2].values[0] == 5);
    CHECK(fields[2].values[11] == kInfinity);
    CHECK(fields[3].values[17] == 20);

    support::spill(folder / "T.sol", "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n1\n1 2\n3 4\nEnd\n");
    const std::vector<Field> planar = read_solution(folder / "T.sol");
    REQUIRE(planar.size() == 1);
    CHECK(planar[0].name == "T");
    CHECK(planar[0].components == 2);

    write_sizes(folder / "h.solb", std::vector{1.0, 2.0, 3.0});
    CHECK(read_solution(folder / "h.solb", 3)[0].values == std::vector{1.0, 2.0, 3.0});
}

TEST_CASE("solutions that are damaged or for another mesh are refused with the line", "[io]") {
    const TemporaryFolder folder;
    const auto fails = [&](const std::string& text, int line, const std::string& part) {
        support::spill(folder / "a.sol", "MeshVersionFormatted 2\nDimension 3\n" + text);
        CAPTURE(text);
        try {
            read_solution(folder / "a.sol", 2);
            FAIL("read");
        } catch (const IoError& error) {
            CHECK_THAT(error.what(), Catch::Contains("a.sol:" + std::to_string(line) + ": ") && Catch::Contains(part));
        }
    };
    fails("SolAtVertices\n3\n1 1\n1\n2\n3\nEnd\n", 4, "3 vertices, but the mesh has 2");
    fails("SolAtVertices\n2\n1 5\n1\n2\nEnd\n", 5, "unknown kind of a field: 5");
    fails("SolAtVertices\n2\n0\n1\n2\nEnd\n", 5, "the number of fields is 0");
    fails("SolAtVertices\n2\n1 2\n1 2 3\n4 5\nEnd\n", 8, "a value");
    fails("SolAtVertices\n2\n2 1 1\n1 2\n3\n", 7, "a value");
    fails("Vertices\n2\n", 4, "holds a mesh");
    fails("End\n", 3, "has no SolAtVertices");
    CHECK_THROWS_AS(read_solution(folder / "a.mesh"), IoError);
}
