// The program on planar domains.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "gradus/io/input_file.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/closest.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "gradus/quality/shape.hpp"
#include "support/files.hpp"
#include "support/program.hpp"

using namespace gradus;
using support::Outcome;
using support::run;
using support::TemporaryFolder;

namespace {

struct Drawing {
    std::vector<Eigen::Vector2d> points;
    std::vector<std::array<int, 3>> segments;  // ends, label

    void add_loop(const std::vector<Eigen::Vector2d>& corners, int label) {
        const int first = static_cast<int>(points.size()), n = static_cast<int>(corners.size());
        for (int i = 0; i < n; ++i) {
            points.push_back(corners[i]);
            segments.push_back({first + i, first + (i + 1) % n, label});
        }
    }
    void add_circle(double x, double y, double radius, int sides, int label) {
        std::vector<Eigen::Vector2d> corners;
        for (int k = 0; k < sides; ++k) {
            const double angle = 2 * std::numbers::pi * k / sides;
            corners.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle));
        }
        add_loop(corners, label);
    }
    std::string medit() const {
        std::ostringstream text;
        text.precision(17);
        text << "MeshVersionFormatted 2\nDimension 2\nVertices\n" << points.size() << '\n';
        for (const Eigen::Vector2d& p : points) text << p.x() << ' ' << p.y() << " 0\n";
        text << "Edges\n" << segments.size() << '\n';
        for (const auto& [a, b, label] : segments) text << a + 1 << ' ' << b + 1 << ' ' << label << '\n';
        text << "End\n";
        return text.str();
    }
    std::string poly(const std::string& holes_and_regions) const {
        std::ostringstream text;
        text.precision(17);
        text << points.size() << " 2 0 0\n";
        for (std::size_t i = 0; i < points.size(); ++i)
            text << i << ' ' << points[i].x() << ' ' << points[i].y() << '\n';
        text << segments.size() << " 1\n";
        for (std::size_t s = 0; s < segments.size(); ++s)
            text << s << ' ' << segments[s][0] << ' ' << segments[s][1] << ' ' << segments[s][2] << '\n';
        text << holes_and_regions;
        return text.str();
    }
};

Drawing square(double side) {
    Drawing drawing;
    drawing.points = {{0, 0}, {side, 0}, {side, side}, {0, side}};
    drawing.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
    return drawing;
}

double area(const TriangleSoup& soup, int label = -1) {
    double sum = 0;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        const auto& [a, b, c] = soup.triangles[t];
        if (label < 0 || soup.labels[t] == label)
            sum += (soup.points[b] - soup.points[a]).cross(soup.points[c] - soup.points[a]).z() / 2;
    }
    return sum;
}

ShapeReport shape_of(const TriangleSoup& soup) {
    const MeshView view{soup.points, soup.triangles};
    return measure_shape(view, edges_of(view));
}

}  // namespace

TEST_CASE("a square of side 10 with sizes 1 has ten edges a side, its area and its labels", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.mesh", square(10).medit());
    const std::string out = GENERATE("out.mesh", "out.meshb");
    const Outcome outcome = run(folder, "remesh square.mesh -o " + out + " --hmin 1 --hmax 1");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const TriangleSoup mesh = read_mesh(folder / out);
    CHECK(mesh.dimension == 2);
    CHECK(std::abs(static_cast<double>(mesh.triangles.size()) - 231) < 0.15 * 231);
    CHECK(area(mesh) == Approx(100).epsilon(1e-13));
    CHECK(is_clean_manifold(diagnose(mesh)));
    std::map<int, int> edges;
    for (const int label : mesh.edge_labels) ++edges[label];
    CHECK(edges == std::map<int, int>{{1, 10}, {2, 10}, {3, 10}, {4, 10}});
    CHECK(shape_of(mesh).area_length.min > 0.8);
}

TEST_CASE("holes, interfaces and lines of a planar domain are kept", "[cli]") {
    const TemporaryFolder folder;
    Drawing drawing = square(4);
    drawing.add_circle(1, 1, 0.4, 64, 5);
    drawing.add_circle(3, 3, 0.5, 64, 6);
    const int line = static_cast<int>(drawing.points.size());
    drawing.points.insert(drawing.points.end(), {{0.5, 3.5}, {2, 2}});
    drawing.segments.push_back({line, line + 1, 7});
    support::spill(folder / "in.poly", drawing.poly("1\n0 1 1\n2\n0 0.1 0.1 10\n1 3 3 20 0.1\n"));
    const Outcome outcome = run(folder, "remesh in.poly -o out.mesh --shock 1.3");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    const TriangleSoup mesh = read_mesh(folder / "out.mesh");
    CHECK(is_clean_manifold(diagnose(mesh)));
    CHECK(diagnose(mesh).boundary_loops == 2);
    const double pi = std::numbers::pi;
    CHECK(area(mesh, 10) == Approx(16 - pi * (0.16 + 0.25)).epsilon(0.005));
    CHECK(area(mesh, 20) == Approx(pi * 0.25).epsilon(0.02));
    double line_length = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (mesh.edge_labels[e] == 7)
            line_length += (mesh.points[mesh.edges[e][1]] - mesh.points[mesh.edges[e][0]]).norm();
    CHECK(line_length == Approx(1.5 * std::sqrt(2)).epsilon(1e-12));
    const ShapeReport shape = shape_of(mesh);
    CHECK(shape.area_length.min > 0.6);
    CHECK(shape.area_length.mean > 0.965);
}

TEST_CASE("corners stay, however short the segments beside them are", "[cli][regression]") {
    const TemporaryFolder folder;
    // A rectangle with further points on its sides, one of them very near to a corner.
    for (const double near : {1e-5, 3e-4, 0.01, 0.5}) {
        CAPTURE(near);
        Drawing drawing;
        drawing.add_loop({{0, 0}, {near, 0}, {1.7, 0}, {4, 0}, {4, 2}, {0, 2}, {0, near}}, 1);
        support::spill(folder / "in.mesh", drawing.medit());
        REQUIRE(run(folder, "remesh in.mesh -o out.mesh").code == 0);
        CHECK(area(read_mesh(folder / "out.mesh")) == Approx(8).epsilon(1e-12));
    }
    // An airfoil with cosine spacing keeps its trailing edge, and its surroundings are no finer than sizes ask for.
    Drawing foil;
    foil.add_loop({{-6, -5}, {7, -5}, {7, 5}, {-6, 5}}, 2);
    std::vector<Eigen::Vector2d> outline;
    constexpr int n = 60;
    for (int k = 0; k < 2 * n; ++k) {
        const double x = (1 + std::cos(std::numbers::pi * k / n)) / 2,
                     half = 0.6 * (0.2969 * std::sqrt(x) - 0.126 * x - 0.3516 * x * x + 0.2843 * x * x * x -
                                   0.1036 * x * x * x * x);
        outline.emplace_back(x, k < n ? half : -half);
    }
    foil.add_loop(outline, 1);
    support::spill(folder / "foil.mesh", foil.medit());
    REQUIRE(run(folder, "remesh foil.mesh -o out.mesh").code == 0);
    const TriangleSoup mesh = read_mesh(folder / "out.mesh");
    const auto is_tip = [](const Eigen::Vector3d& p) { return (p - Eigen::Vector3d(1, 0, 0)).norm() < 1e-12; };
    CHECK(std::any_of(mesh.points.begin(), mesh.points.end(), is_tip));
    CHECK(mesh.triangles.size() < 800);  // with a growth of 1.5 from the foil 520 to 680 are ideal
    CHECK(shape_of(mesh).area_length.min > 0.8);
}

namespace {

// How far samples of the edges of one label are from those of another mesh.
double off_lines(const TriangleSoup& from, const TriangleSoup& to, int label) {
    double farthest = 0;
    for (std::size_t e = 0; e < from.edges.size(); ++e) {
        if (from.edge_labels[e] != label) continue;
        for (int k = 0; k <= 10; ++k) {
            const Eigen::Vector3d &a = from.points[from.edges[e][0]], &b = from.points[from.edges[e][1]],
                                  p = a + k / 10.0 * (b - a);
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t f = 0; f < to.edges.size(); ++f) {
                if (to.edge_labels[f] != label) continue;
                const Eigen::Vector3d &c = to.points[to.edges[f][0]], &d = to.points[to.edges[f][1]];
                nearest = std::min(nearest, (closest_point(p, c, d, d) - p).norm());
            }
            farthest = std::max(farthest, nearest);
        }
    }
    return farthest;
}

}  // namespace

TEST_CASE("a chord error holds of outlines and of lines inside, both ways", "[cli]") {
    const TemporaryFolder folder;
    Drawing drawing = square(2);
    drawing.add_circle(1, 1, 0.5, 25, 5);
    support::spill(folder / "in.poly", drawing.poly("0\n1\n0 0.1 0.1 3\n"));
    const TriangleSoup input = read_mesh(folder / "in.poly");
    for (const char* error : {"0.01", "0.002"}) {
        CAPTURE(error);
        const Outcome outcome = run(folder, std::string("remesh in.poly -o out.mesh --chord-error ") + error);
        REQUIRE(outcome.code == 0);
        const TriangleSoup mesh = read_mesh(folder / "out.mesh");
        CHECK(off_lines(input, mesh, 5) <= std::stod(error));
        CHECK(off_lines(mesh, input, 5) <= std::stod(error));
    }
    // Without one the distance that is told is of the lines too.
    const Outcome outcome = run(folder, "remesh in.poly -o out.mesh --hmin 0.5 --hmax 0.5 --json");
    REQUIRE(outcome.code == 0);
    const double off = off_lines(input, read_mesh(folder / "out.mesh"), 5);
    CHECK(off > 0.01);
    CHECK(nlohmann::json::parse(outcome.out)["distance"]["from_input"]["bound"].get<double>() >= off);
}

TEST_CASE("regions and holes may meet in a point", "[cli][regression]") {
    const TemporaryFolder folder;
    Drawing bowtie;
    bowtie.points = {{-1, -1}, {0, 0}, {-1, 1}, {1, -1}, {1, 1}};
    bowtie.segments = {{0, 1, 1}, {1, 2, 1}, {2, 0, 1}, {1, 3, 2}, {3, 4, 2}, {4, 1, 2}};
    support::spill(folder / "in.mesh", bowtie.medit());
    const Outcome outcome = run(folder, "remesh in.mesh -o out.mesh");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK(area(read_mesh(folder / "out.mesh")) == Approx(2).epsilon(1e-13));
    CHECK(run(folder, "info in.mesh").out.find("NOT") == std::string::npos);
}

TEST_CASE("labels of the lines of a planar domain are kept by every format that holds some", "[cli]") {
    const TemporaryFolder folder;
    support::spill(folder / "square.mesh", square(2).medit());
    for (const std::string out : {"a.mesh", "a.meshb", "a.msh", "a.vtu"}) {
        CAPTURE(out);
        REQUIRE(run(folder, "remesh square.mesh -o " + out + " --hmin 0.25 --hmax 0.25").code == 0);
        REQUIRE(run(folder, "remesh " + out + " -o again.mesh --hmin 0.5 --hmax 0.5").code == 0);
        const TriangleSoup mesh = read_mesh(folder / "again.mesh");
        REQUIRE(mesh.edge_labels.size() == mesh.edges.size());
        std::map<int, double> length;
        for (std::size_t e = 0; e < mesh.edges.size(); ++e)
            length[mesh.edge_labels[e]] += (mesh.points[mesh.edges[e][1]] - mesh.points[mesh.edges[e][0]]).norm();
        REQUIRE(length.size() == 4);
        for (const auto& [label, sum] : length) CHECK(sum == Approx(2).epsilon(1e-12));
    }
}

TEST_CASE("a size map of a planar domain and its background are of dimension 2, and lead to a mesh", "[cli]") {
    const TemporaryFolder folder;
    Drawing drawing = square(2);
    drawing.add_circle(1, 1, 0.2, 64, 5);
    support::spill(folder / "in.mesh", drawing.medit());
    const Outcome map = run(folder, "sizemap in.mesh -o raw.sol --background bg.mesh --hmin 0.02 --hmax 0.3");
    CAPTURE(map.err);
    REQUIRE(map.code == 0);
    REQUIRE(run(folder, "grade bg.mesh --size raw.sol --shock 1.3 -o graded.sol").code == 0);
    for (const char* name : {"bg.mesh", "raw.sol", "graded.sol"})
        CHECK_THAT(read_file(folder / name), Catch::Contains("Dimension 2\n"));
    const Outcome mesh = run(folder, "remesh in.mesh --size graded.sol --background bg.mesh --shock 1.3 -o out.mesh");
    CAPTURE(mesh.err);
    REQUIRE(mesh.code == 0);
    CHECK(shape_of(read_mesh(folder / "out.mesh")).area_length.min > 0.7);
}

TEST_CASE("info tells areas, holes and lines of a planar domain", "[cli]") {
    const TemporaryFolder folder;
    Drawing drawing = square(2);
    drawing.add_loop({{0.5, 0.5}, {1, 0.5}, {1, 1}, {0.5, 1}}, 9);
    support::spill(folder / "in.poly", drawing.poly("0\n2\n0 0.1 0.1 3\n1 0.7 0.7 4\n"));
    const Outcome text = run(folder, "info in.poly");
    CHECK_THAT(text.out, Catch::Contains("area 4;") && Catch::Contains("3: 3.75 in") && Catch::Contains("4: 0.25 in") &&
                             Catch::Contains("9: 2 in 4 edges; 4 edges inside"));
}

TEST_CASE("info and refusals of planar domains name what is wrong with its place", "[cli]") {
    const TemporaryFolder folder;
    Drawing crossing = square(1);
    std::swap(crossing.points[2], crossing.points[3]);
    Drawing open = square(1);
    open.segments.pop_back();
    const std::vector<std::pair<std::string, std::string>> cases{
        {crossing.medit(), "segment 4-1 crosses 3-2 at (0.5, 0.5)"},
        {open.medit(), "the outline is open at point 1 at (0, 0)"},
        {"MeshVersionFormatted 2\nDimension 2\nVertices\n2\n0 0 0\n1 1 0\nEnd\n", "has no Triangles"},
    };
    for (const auto& [text, message] : cases) {
        support::spill(folder / "in.mesh", text);
        for (const char* command : {"info in.mesh", "remesh in.mesh -o out.mesh"}) {
            const Outcome outcome = run(folder, command);
            CHECK(outcome.code != 0);
            CHECK_THAT(outcome.err, Catch::StartsWith("gradus: error: in.mesh") && Catch::Contains(message));
        }
    }
    support::spill(folder / "in.poly", square(1).poly("1\n0 5 5\n"));
    CHECK_THAT(run(folder, "info in.poly").err, Catch::Contains("in.poly: the hole at (5, 5) is in no region"));
    support::spill(folder / "in.poly", square(1).poly("0\n1\n0 0.5 0.5 1e300\n"));
    CHECK_THAT(run(folder, "info in.poly").err, Catch::Contains("must be a whole number"));
    support::spill(folder / "in.poly", "0 2 0 0\n1 0\n0 0 1\n0\n");
    CHECK_THAT(run(folder, "info in.poly").err, Catch::Contains("has no points") && Catch::Contains("in.node"));
    support::spill(folder / "in.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n");
    support::spill(folder / "in.poly", "0 2 0 0\n3 0\n1 1 2\n2 2 3\n3 3 1\n0\n");
    CHECK(run(folder, "info in.poly").code == 0);
}
