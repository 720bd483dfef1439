#include "gradus/remesh/adapt_planar.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "gradus/mesh/diagnose.hpp"
#include "gradus/plane/planar_graph.hpp"

using namespace gradus;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

PlanarGraph square(double low, double high) {
    PlanarGraph graph;
    graph.points = {{low, low}, {high, low}, {high, high}, {low, high}};
    graph.segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    return graph;
}

std::unique_ptr<Triangulation> domain_of(const PlanarGraph& graph) {
    return std::make_unique<Triangulation>(triangulate(graph, InnerPoints::Added));
}

double area(const TriangleSoup& soup) {
    double sum = 0;
    for (const auto& [a, b, c] : soup.triangles) {
        const double twice = (soup.points[b] - soup.points[a]).cross(soup.points[c] - soup.points[a]).z();
        CHECK(twice > 0);
        sum += twice / 2;
    }
    return sum;
}

Tensor along_axes(double hx, double hy) {
    return size_tensor(metric_along(Matrix3d::Identity(), {hx, hy, std::sqrt(hx * hy)}));
}

double ring(const Vector3d& p) {
    const double r2 = p.squaredNorm();
    return r2 >= .99 && r2 <= 1.01 ? .005 : r2 > 1.01 ? 1.0 : .1;
}

}  // namespace

TEST_CASE("What is thin is found, though no vertex lies in it", "[property]") {
    const auto domain = domain_of(square(-2, 2));
    const auto background = sampled_background<Size>(domain->soup().points, domain->mesh(), ring);
    CHECK(background.is_fine_enough);
    // Seen from the centre the ring is there in every direction.
    const ControlSpace field(background.points, background.mesh, background.sizes);
    int cell = 0;
    for (int i = 0; i < 1000; ++i) {
        const double angle = 2 * std::numbers::pi * i / 1000;
        CHECK(field.size({std::cos(angle), std::sin(angle), 0}, cell) < .0051);
    }
    // The triangles that it asks for: over the ring, the disc and what is left.
    const double pi = std::numbers::pi, over = 4 / std::sqrt(3.0);
    const double ideal = over * (.02 * pi / (.005 * .005) + .99 * pi / .01 + (16 - 1.01 * pi));
    CHECK(field.predicted_triangles() == Approx(ideal).epsilon(.12));
}

TEST_CASE("The ring of three sizes is meshed well once it is corrected", "[remesh]") {
    const auto domain = domain_of(square(-2, 2));
    const auto result = adapt_planar<Size>(*domain, ring, {.gradation = GradationOptions{.shock = 2}});
    CHECK(result.converged);
    CHECK(result.graded);
    CHECK(result.iterations.size() <= 3);
    const PlanarAdaptIteration& last = result.iterations.back();
    CHECK(last.own.worst > .7);
    CHECK(last.own.mean > .945);
    CHECK(last.own.unit_share > .98);
    CHECK(last.own.longest < 1.7);
    CHECK(last.triangles == Approx(last.predicted_triangles).epsilon(.06));
    CHECK(area(result.mesh) == Approx(16).epsilon(1e-12));
    CHECK(is_clean_manifold(diagnose(result.mesh)));
    CHECK(result.sizes.size() == result.mesh.points.size());
}

TEST_CASE("Metrics of one direction are meshed as what they are", "[remesh]") {
    // Of NASA's adaptive mesh mechanics benchmarks; they accept edges in [.40, 1.8].
    const auto domain = domain_of(square(0, 1));
    const auto wanted = [](const Vector3d& p) { return along_axes(.1, 1e-4 + .1998 * std::abs(p.y() - .5)); };
    const auto result = adapt_planar<SizeTensor>(*domain, wanted);
    CHECK(result.converged);
    const MetricFit& fit = result.iterations.back().own;
    CHECK(fit.worst > .8);
    CHECK(fit.mean > .96);
    CHECK(fit.unit_share > .98);
    CHECK(fit.shortest > .45);
    CHECK(fit.longest < 1.8);
    CHECK(area(result.mesh) == Approx(1).epsilon(1e-12));
}

TEST_CASE("A metric of one size makes a mesh as good as the size", "[remesh]") {
    const auto domain = domain_of(square(0, 1));
    const auto size = adapt_planar<Size>(*domain, [](const Vector3d&) { return .05; });
    const auto metric = adapt_planar<SizeTensor>(*domain, [](const Vector3d&) { return round_tensor(.05); });
    CHECK(size.converged);
    CHECK(metric.converged);
    CHECK(static_cast<double>(metric.mesh.triangles.size()) ==
          Approx(static_cast<double>(size.mesh.triangles.size())).epsilon(.05));
    CHECK(metric.iterations.back().own.worst > .8);
    CHECK(metric.iterations.back().own.mean == Approx(size.iterations.back().own.mean).epsilon(.01));
}

TEST_CASE("Labels, holes, lines and what is required stay in an adapted mesh", "[remesh]") {
    PlanarGraph graph = square(0, 4);
    graph.labels = {1, 2, 3, 4};
    const auto loop = [&](double x, double y, double r, int label) {
        const int first = static_cast<int>(graph.points.size());
        for (int k = 0; k < 48; ++k) {
            graph.points.emplace_back(x + r * std::cos(2 * std::numbers::pi * k / 48),
                                      y + r * std::sin(2 * std::numbers::pi * k / 48));
            graph.segments.push_back({first + k, first + (k + 1) % 48});
            graph.labels.push_back(label);
        }
    };
    loop(1, 1, .5, 5);
    loop(3, 3, .5, 6);
    graph.holes = {{{1, 1}}};
    graph.regions = {{{.1, .1}, 10}, {{3, 3}, 20}};
    graph.points.push_back({2, 1});
    const int alone = static_cast<int>(graph.points.size()) - 1;
    const auto domain = domain_of(graph);
    const auto wanted = [](const Vector3d& p) { return along_axes(.1, .02 + .1 * std::abs(p.y() - 2)); };
    const auto result =
        adapt_planar<SizeTensor>(*domain, wanted, {.tensor_gradation = TensorGradationOptions{.shock = 1.5}});
    const TriangleSoup& mesh = result.mesh;
    CHECK(is_clean_manifold(diagnose(mesh)));
    CHECK(diagnose(mesh).boundary_loops == 2);
    double inner = 0, all = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const double part = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).z() / 2;
        CHECK(part > 0);
        all += part;
        if (mesh.labels[t] == 20) inner += part;
    }
    const double disc = 24 * .25 * std::sin(2 * std::numbers::pi / 48);
    CHECK(inner == Approx(disc).epsilon(.02));
    CHECK(all == Approx(16 - disc).epsilon(.01));
    std::array<double, 7> length{};
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        length[mesh.edge_labels[e]] += (mesh.points[mesh.edges[e][0]] - mesh.points[mesh.edges[e][1]]).norm();
    for (const int side : {1, 2, 3, 4}) CHECK(length[side] == Approx(4).epsilon(1e-12));
    for (const int circle : {5, 6}) CHECK(length[circle] == Approx(std::numbers::pi).epsilon(.02));
    REQUIRE(mesh.required.vertices.size() == 1);
    CHECK(mesh.points[mesh.required.vertices[0]] == Vector3d(2, 1, 0));
    CHECK(domain->soup().required.vertices == std::vector<int>{alone});
}

TEST_CASE("An adapted mesh is the same on any number of threads", "[property]") {
    const auto domain = domain_of(square(0, 1));
    const auto wanted = [](const Vector3d& p) { return along_axes(.02 + .1 * p.x(), .1); };
    PlanarAdaptOptions one, two;
    one.remesh.threads = 1;
    two.remesh.threads = 2;
    const auto a = adapt_planar<SizeTensor>(*domain, wanted, one), b = adapt_planar<SizeTensor>(*domain, wanted, two);
    CHECK(a.mesh.points == b.mesh.points);
    CHECK(a.mesh.triangles == b.mesh.triangles);
}
