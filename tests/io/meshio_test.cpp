// gradus and meshio read each other's files.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/size_view.hpp"
#include "support/files.hpp"
#include "support/soups.hpp"

using namespace gradus;

namespace {

template <class Number>
std::vector<Number> numbers_in(const std::string& path) {
    const std::string bytes = read_file(path);
    std::vector<Number> numbers(bytes.size() / sizeof(Number));
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

/// What the script read from a file of ours.
TriangleSoup dumped(const std::string& path) {
    const std::vector<double> points = numbers_in<double>(path + ".points");
    const std::vector<int> triangles = numbers_in<int>(path + ".triangles");
    TriangleSoup soup;
    for (std::size_t i = 0; i + 2 < points.size(); i += 3)
        soup.points.push_back({points[i], points[i + 1], points[i + 2]});
    for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
        soup.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    return soup;
}

double largest_difference(const TriangleSoup& a, const TriangleSoup& b) {
    if (a.triangles.size() != b.triangles.size()) return std::numeric_limits<double>::infinity();
    double largest = 0;
    for (std::size_t t = 0; t < a.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            largest =
                std::max(largest, (a.points[a.triangles[t][k]] - b.points[b.triangles[t][k]]).cwiseAbs().maxCoeff());
    return largest;
}

bool has_meshio() { return std::system("/usr/bin/python3 -c 'import meshio' > /dev/null 2>&1") == 0; }

}  // namespace

TEST_CASE("meshio and gradus read each other's files", "[io][meshio]") {
    if (!has_meshio()) {
        WARN("skipped: /usr/bin/python3 has no meshio");
        return;
    }
    const support::TemporaryFolder folder;
    TriangleSoup soup = support::grid(7);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
        soup.labels.push_back(static_cast<int>(t * 3 / soup.triangles.size()) + 4);
    soup.edges = {{0, 1}, {1, 2}};
    soup.corners = {0, 7};
    soup.parameters = {{0, {0, {0, 0}}}, {7, {0, {1, 0}}}, {7, {1, {0, 0.1}}}};
    for (const char* name : {"ours.mesh", "ours.meshb", "ours.msh", "ours.obj", "ours.off", "ours.ply", "ours.stl"})
        write_mesh(folder / name, soup);
    write_mesh(folder / "ours.plain.vtu", soup);
    write_mesh(folder / "ours.unlabelled.msh", {soup.points, soup.triangles});
    write_size_view(folder / "ours.size.msh", {soup.points, soup.triangles},
                    std::vector<double>(soup.points.size(), 0.25));
    write_mesh(folder / "ours.text.ply", soup, {.ascii = true});
    write_mesh(folder / "ours.text.stl", soup, {.ascii = true});
    std::vector<double> size, gradient, quality;
    for (const Eigen::Vector3d& p : soup.points) {
        size.push_back(p.norm());
        for (int i = 0; i < 3; ++i) gradient.push_back(1 / (1 + p[i]));
    }
    size[3] = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) quality.push_back(1.0 / (1.0 + static_cast<double>(t)));
    write_mesh_data(folder / "ours.vtu", {{.points = soup.points, .triangles = soup.triangles},
                                          {{"size", 1, size}, {"grad<h>", 3, gradient}},
                                          {{"quality", 1, quality}}});

    MeshData rich{soup, {{"grad", 3, gradient}, {"size", 1, size}}, {{"quality", 1, quality}}};
    write_mesh_data(folder / "ours.rich.msh", rich);
    rich.soup.edges.clear();
    write_mesh_data(folder / "ours.rich.vtu", rich);
    rich.soup.labels.clear();
    rich.cell_fields.clear();
    write_mesh_data(folder / "ours.rich.ply", rich);

    const std::string command =
        "/usr/bin/python3 '" GRADUS_MESHIO_CHECK "' '" + folder.path().string() + "' > '" + (folder / "log") + "' 2>&1";
    const int status = std::system(command.c_str());
    INFO(read_file(folder / "log"));
    REQUIRE(status == 0);

    constexpr double kSingle = 1e-7;
    for (const char* name : {"ours.mesh", "ours.meshb", "ours.obj", "ours.off", "ours.ply", "ours.text.ply", "ours.vtu",
                             "ours.plain.vtu", "ours.msh", "ours.unlabelled.msh", "ours.size.msh"}) {
        INFO(name);
        const TriangleSoup back = dumped(folder / name);
        CHECK(back.points == soup.points);
        CHECK(back.triangles == soup.triangles);
    }
    CHECK(numbers_in<int>(folder / "ours.msh.labels") == soup.labels);
    for (const char* name : {"ours.msh.lines", "ours.plain.vtu.lines"})
        CHECK(numbers_in<int>(folder / name) == std::vector{0, 1, 1, 2});
    CHECK(numbers_in<double>(folder / "ours.size.msh.field.size") == std::vector<double>(soup.points.size(), 0.25));
    for (const char* name : {"ours.stl", "ours.text.stl"}) {
        INFO(name);
        CHECK(largest_difference(soup, dumped(folder / name)) < kSingle);
    }
    for (const char* name : {"ours.rich.msh", "ours.rich.vtu"}) {
        CHECK(numbers_in<double>(folder / (std::string(name) + ".field.grad")) == gradient);
        CHECK(numbers_in<double>(folder / (std::string(name) + ".field.size")) == size);
        CHECK(numbers_in<double>(folder / (std::string(name) + ".field.quality")) == quality);
    }
    CHECK(numbers_in<double>(folder / "ours.rich.ply.field.size") == size);
    CHECK(numbers_in<double>(folder / "ours.vtu.field.size") == size);
    CHECK(numbers_in<double>(folder / "ours.vtu.field.grad<h>") == gradient);
    CHECK(numbers_in<double>(folder / "ours.vtu.field.quality") == quality);

    for (const char* name :
         {"theirs.mesh", "theirs.meshb", "theirs.obj", "theirs.off", "theirs-text.ply", "theirs.ply"}) {
        INFO(name);
        const TriangleSoup theirs = read_mesh(folder / name);
        CHECK(theirs.triangles == soup.triangles);
        CHECK(largest_difference(soup, theirs) < 1e-15);
    }
    for (const char* name : {"theirs-text.stl", "theirs.stl"}) {
        INFO(name);
        CHECK(largest_difference(soup, read_mesh(folder / name)) < kSingle);
        CHECK(read_mesh(folder / name).points.size() == soup.points.size());
    }

    std::vector<double> values, flow, q;
    for (std::size_t i = 0; i < soup.points.size(); ++i) {
        values.push_back(1 / (1 + static_cast<double>(i)));
        for (int k = 0; k < 3; ++k) flow.push_back(static_cast<double>(flow.size()) / 7);
    }
    for (const int label : soup.labels) q.push_back(label / 3.0);
    const auto field = [](const std::vector<Field>& fields, const std::string& called) {
        for (const Field& f : fields)
            if (f.name == called) return f.values;
        return std::vector<double>{};
    };
    for (const char* name : {"theirs22a.msh", "theirs22b.msh", "theirs41a.msh", "theirs41b.msh", "theirs-text.vtu",
                             "theirs-plain.vtu", "theirs-zlib.vtu"}) {
        INFO(name);
        const MeshData theirs = read_mesh_data(folder / name);
        const bool rounded = std::string(name) == "theirs-text.vtu";  // to 12 digits
        if (!rounded) CHECK(theirs.soup.points == soup.points);
        CHECK(largest_difference(theirs.soup, soup) < 1e-11);
        CHECK(theirs.soup.triangles == soup.triangles);
        CHECK(theirs.soup.labels == soup.labels);
        CHECK(theirs.soup.edges == soup.edges);
        const std::vector<double> found[3] = {field(theirs.point_fields, "size"), field(theirs.point_fields, "flow"),
                                              field(theirs.cell_fields, "q")};
        if (!rounded) {
            CHECK(found[0] == values);
            CHECK(found[1] == flow);
            CHECK(found[2] == q);
        } else {
            CHECK_THAT(found[0], Catch::Approx(values).epsilon(1e-11));
            CHECK_THAT(found[1], Catch::Approx(flow).epsilon(1e-11));
            CHECK_THAT(found[2], Catch::Approx(q).epsilon(1e-11));
        }
    }
    for (const char* name : {"quads22.msh", "quads41.msh", "quads.vtu"}) {
        INFO(name);
        const MeshData theirs = read_mesh_data(folder / name);
        CHECK(theirs.soup.points.size() == soup.points.size() - 3);  // without the middles of sides
        CHECK(theirs.soup.triangles ==
              std::vector<Triangle>{{0, 1, 9}, {0, 9, 8}, {1, 2, 10}, {1, 10, 9}, {16, 17, 21}});
        CHECK(field(theirs.cell_fields, "q") == std::vector{5.0, 5.0, 6.0, 6.0, 7.0});
    }
}

TEST_CASE("fields that do not fit are refused", "[io]") {
    const support::TemporaryFolder folder;
    const TriangleSoup soup = support::grid(2);
    const std::vector<double> nine(9), eight(8);
    const auto write = [&](const std::vector<Field>& at_points, const std::vector<Field>& at_cells) {
        write_mesh_data(folder / "a.vtu", {soup, at_points, at_cells});
    };
    CHECK_NOTHROW(write({{"a", 1, nine}}, {{"a", 1, eight}}));
    CHECK_THROWS_AS(write({{"a", 1, eight}}, {}), std::invalid_argument);
    CHECK_THROWS_AS(write({}, {{"a", 2, eight}}), std::invalid_argument);
    CHECK_THROWS_AS(write({{"", 1, nine}}, {}), std::invalid_argument);
    CHECK_THROWS_AS(write({{"a", 1, nine}, {"a", 1, nine}}, {}), std::invalid_argument);
    CHECK_THROWS_AS(write_mesh_data(folder / "a.vtu", {{.points = soup.points, .triangles = {{0, 1, 9}}}}),
                    std::invalid_argument);
}
