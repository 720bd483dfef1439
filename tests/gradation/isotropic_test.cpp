#include "gradus/gradation/isotropic.hpp"

#include "gradus/gradation/measures.hpp"
#include "maps.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::test;

namespace {

struct NeighbourEdge {
    int a, b;
    double length;
};

std::vector<NeighbourEdge> edges_of(const Tris& t) {
    std::vector<NeighbourEdge> edges;
    for (const Triangle& triangle : t.triangles)
        for (int k = 0; k < 3; ++k) {
            const int a = triangle[k], b = triangle[(k + 1) % 3];
            edges.push_back({a, b, (t.points[a] - t.points[b]).norm()});
        }
    return edges;
}

/// Bellman and Ford: relax every edge both ways until nothing changes.
std::vector<double> brute_variation(const Tris& t, double bound, std::vector<double> h) {
    for (bool changed = true; changed;) {
        changed = false;
        for (const auto& [a, b, L] : edges_of(t))
            for (const auto& [p, q] : {std::pair{a, b}, std::pair{b, a}})
                if (h[q] > h[p] + bound * L) {
                    h[q] = h[p] + bound * L;
                    changed = true;
                }
    }
    return h;
}

/// Root of (20) by bisection on r.
double brute_shock_limit(double h, double L, double beta) {
    double low = 1, high = 2;
    const auto shock = [&](double r) { return std::log(r) * std::log(r) * r / (r - 1) * h / L; };
    while (shock(high) < std::log(beta)) high *= 2;
    for (int i = 0; i < 200; ++i) {
        const double middle = .5 * (low + high);
        (shock(middle) < std::log(beta) ? low : high) = middle;
    }
    return h * low;
}

/// Label setting by searching the smallest unsettled vertex each time.
std::vector<double> brute_shock(const Tris& t, double beta, std::vector<double> h) {
    std::vector<char> settled(h.size(), 0);
    const std::vector<NeighbourEdge> edges = edges_of(t);
    for (std::size_t step = 0; step < h.size(); ++step) {
        int v = -1;
        for (int w = 0; w < static_cast<int>(h.size()); ++w)
            if (!settled[w] && (v < 0 || h[w] < h[v])) v = w;
        settled[v] = 1;
        if (std::isinf(h[v])) break;
        for (const auto& [a, b, L] : edges) {
            if (a != v && b != v) continue;
            const int q = a + b - v;
            if (!settled[q] && h_shock(L, h[v], h[q]) > beta) h[q] = std::min(h[q], brute_shock_limit(h[v], L, beta));
        }
    }
    return h;
}

double largest_difference(const std::vector<double>& p, const std::vector<double>& q) {
    double d = 0;
    for (std::size_t v = 0; v < p.size(); ++v)
        if (p[v] != q[v]) d = std::max(d, std::abs(p[v] - q[v]) / std::min(p[v], q[v]));
    return d;
}

}  // namespace

TEST_CASE("Along a line the variation bound gives straight ramps", "[gradation][exact]") {
    const Tris t = strip(20, .5, 1000);
    const TriMesh mesh = t.mesh();
    std::vector<double> size(t.points.size(), INFINITY);
    size[4] = .25;
    const EdgeReduction result = limit_h_variation(mesh, .2, size);
    for (int i = 0; i <= 20; ++i) CHECK(size[i] == Approx(.25 + .2 * .5 * std::abs(i - 4)).epsilon(1e-13));
    CHECK(result.lowered == static_cast<int>(t.points.size()) - 1);
    CHECK(std::isinf(result.largest_factor));
    CHECK(result.certificate.parent[7] == 6);
    CHECK(result.certificate.parent[4] == -1);
}

TEST_CASE("Along a line the shock bound is met with equality", "[gradation][exact]") {
    const double beta = GENERATE(1.05, 1.5, 3.);
    const Tris t = strip(20, .5, 1000);
    const TriMesh mesh = t.mesh();
    std::vector<double> size(t.points.size(), INFINITY);
    size[4] = .25;
    limit_h_shock(mesh, beta, size);
    for (int i = 0; i < 20; ++i) CHECK(h_shock(.5, size[i], size[i + 1]) == Approx(beta).epsilon(1e-12));
}

TEST_CASE("The limit of a neighbour solves equation 20", "[gradation][exact]") {
    for (const double beta : {1.0001, 1.05, 1.5, 2., 10.})
        for (double L = 1e-8; L < 1e4; L *= 3) {
            const double h = shock_limit(1, L, beta);
            CHECK(h == Approx(brute_shock_limit(1, L, beta)).epsilon(2e-13));
            CHECK(h_shock(L, 1, h) <= beta * (1 + 1e-12));
            CHECK(h >= (1 + L * std::log(beta)) * (1 - 1e-15));
        }
    CHECK(shock_limit(2, 0, 1.5) == 2);
}

TEST_CASE("The exact variation correction equals the fixpoint of all relaxations", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    const Tris t = random_tris(seed, 9, 7);
    std::vector<double> size = random_sizes(seed, t.points.size(), .05, 50);
    const std::vector<double> input = size;
    const EdgeReduction result = limit_h_variation(t.mesh(), .3, size);
    CHECK(largest_difference(size, brute_variation(t, .3, input)) < 1e-14);
    CHECK(check_variation_certificate(t.mesh(), .3, input, size, result.certificate) == std::nullopt);
}

TEST_CASE("The exact shock correction equals plain label setting", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    const double smallest = GENERATE(.05, .5);  // with and without coarse edges
    const Tris t = random_tris(seed, 9, 7);
    std::vector<double> size = random_sizes(seed, t.points.size(), smallest, 50);
    const std::vector<double> input = size;
    const EdgeReduction result = limit_h_shock(t.mesh(), 1.5, size);
    CHECK(largest_difference(size, brute_shock(t, 1.5, input)) < 1e-12);
    CHECK(check_shock_certificate(t.mesh(), 1.5, input, size, result.certificate) == std::nullopt);
    CHECK((result.coarse_edges > 0) == (smallest < .1));
}

TEST_CASE("Exact corrections bound, lower only, repeat themselves and scale", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 6u));
    const double scale = GENERATE(1e-6, 1., 1e6), beta = GENERATE(1.1, 1.5, 2.);
    Tris t = random_tris(seed, 20, 15);
    std::vector<double> input = random_sizes(seed, t.points.size(), .3, 100);
    for (std::size_t v = 0; v < input.size(); v += 3) input[v] = INFINITY;
    std::vector<double> unit = input;
    limit_h_shock(t.mesh(), beta, unit);

    for (Eigen::Vector3d& p : t.points) p *= scale;
    for (double& h : input) h *= scale;
    const TriMesh mesh = t.mesh();
    std::vector<double> shock = input, variation = input;
    const EdgeReduction result = limit_h_shock(mesh, beta, shock);
    limit_h_variation(mesh, std::log(beta), variation);
    int lowered = 0;
    for (std::size_t v = 0; v < input.size(); ++v) {
        CHECK(shock[v] <= input[v]);
        lowered += shock[v] < input[v];
        // A variation of ln(beta) implies a shock of beta.
        CHECK(variation[v] <= shock[v] * (1 + 1e-13));
        CHECK(shock[v] == Approx(scale * unit[v]).epsilon(1e-12));
    }
    CHECK(result.lowered == lowered);
    CHECK(measure_gradation(mesh, shock).shock_max <= beta * (1 + 1e-12));
    CHECK(measure_gradation(mesh, variation).variation_max <= std::log(beta) * (1 + 1e-12));
    CHECK(measure_gradation(mesh, variation).shock_max <= beta * (1 + 1e-12));

    std::vector<double> again = shock;
    CHECK(limit_h_shock(mesh, beta, again).lowered == 0);
    CHECK(again == shock);
    again = variation;
    CHECK(limit_h_variation(mesh, std::log(beta), again).lowered == 0);
}

TEST_CASE("The numbering of vertices has no influence", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 6u));
    const Tris t = random_tris(seed, 14, 11);
    const std::vector<int> to = permutation(seed + 100, static_cast<int>(t.points.size()));
    const std::vector<double> input = random_sizes(seed, t.points.size(), .02, 100);
    std::vector<double> moved(input.size());
    for (std::size_t v = 0; v < to.size(); ++v) moved[to[v]] = input[v];
    std::vector<double> size = input;
    limit_h_shock(t.mesh(), 1.4, size);
    limit_h_shock(renumbered(t, to).mesh(), 1.4, moved);
    for (std::size_t v = 0; v < to.size(); ++v) CHECK(moved[to[v]] == size[v]);
}

TEST_CASE("A larger input never gives a smaller result", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 6u));
    const Tris t = random_tris(seed, 14, 11);
    Random random(seed);
    std::vector<double> small = random_sizes(seed, t.points.size(), .5, 100), large = small;
    for (double& h : large) h *= random(0, 1) < .3 ? random(1, 5) : 1;
    std::vector<double> small_shock = small, large_shock = large;
    limit_h_variation(t.mesh(), .4, small);
    limit_h_variation(t.mesh(), .4, large);
    limit_h_shock(t.mesh(), 1.5, small_shock);
    limit_h_shock(t.mesh(), 1.5, large_shock);
    for (std::size_t v = 0; v < small.size(); ++v) {
        CHECK(small[v] <= large[v]);
        CHECK(small_shock[v] <= large_shock[v] * (1 + 1e-14));
    }
}

TEST_CASE("A tampered certificate is found out", "[gradation]") {
    const Tris t = random_tris(4, 9, 7);
    const TriMesh mesh = t.mesh();
    const std::vector<double> input = random_sizes(4, t.points.size(), .05, 50);
    std::vector<double> size = input;
    const EdgeReduction good = limit_h_shock(mesh, 1.5, size);
    const auto fault = [&](const std::vector<double>& h, const Certificate& c) {
        return check_shock_certificate(mesh, 1.5, input, h, c);
    };
    REQUIRE(fault(size, good.certificate) == std::nullopt);
    REQUIRE(good.certificate.order.size() > 10);
    const int v = good.certificate.order[5];

    for (const double factor : {.999999, 1.000001}) {
        std::vector<double> h = size;
        h[v] *= factor;
        CHECK(fault(h, good.certificate) != std::nullopt);
    }
    Certificate bad = good.certificate;
    bad.parent[v] = -1;
    CHECK(fault(size, bad) != std::nullopt);
    bad = good.certificate;
    bad.parent[v] = v;
    CHECK(fault(size, bad) != std::nullopt);
    bad = good.certificate;
    bad.order.pop_back();
    CHECK(fault(size, bad) != std::nullopt);
    bad = good.certificate;
    std::reverse(bad.order.begin(), bad.order.end());
    CHECK(fault(size, bad) != std::nullopt);
}

TEST_CASE("Required sizes stay, and say what would have been needed", "[gradation]") {
    const Tris t = strip(10, 1, 1000);
    const TriMesh mesh = t.mesh();
    std::vector<double> input(t.points.size(), INFINITY);
    input[2] = 1;
    input[6] = 5;
    std::vector<double> size = input;
    const std::vector<int> required{2, 6};
    const EdgeReduction result = limit_h_variation(mesh, .5, size, required);
    CHECK(size[2] == 1);
    CHECK(size[6] == 5);
    REQUIRE(result.conflicts.size() == 1);
    CHECK(result.conflicts[0].vertex == 6);
    CHECK(result.conflicts[0].neighbour == 5);
    CHECK(result.conflicts[0].origin == 2);
    CHECK(result.conflicts[0].size == 5);
    CHECK(result.conflicts[0].needed == Approx(3));
    // Everywhere else the bound holds.
    for (int i = 0; i < 10; ++i)
        if (i != 5) CHECK(h_variation(1, size[i], size[i + 1]) <= (i == 6 ? 10. : .5 * (1 + 1e-12)));
    CHECK(check_variation_certificate(mesh, .5, input, size, result.certificate, required) == std::nullopt);
    CHECK(check_variation_certificate(mesh, .5, input, size, result.certificate) != std::nullopt);

    size = input;
    size[6] = 2.5;
    CHECK(limit_h_variation(mesh, .5, size, required).conflicts.empty());
    CHECK_THROWS_AS(limit_h_variation(mesh, .5, size = input, std::vector<int>{0}), std::invalid_argument);
    CHECK_THROWS_AS(limit_h_variation(mesh, .5, size, std::vector<int>{-1}), std::invalid_argument);
}

TEST_CASE("The paper's procedures meet the bound but lower more", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 5u));
    const Tris t = random_tris(seed, 20, 15);
    const TriMesh mesh = t.mesh();
    std::vector<double> input = random_sizes(seed, t.points.size(), .3, 30);
    input[7] = INFINITY;
    std::vector<double> exact = input, paper = input, exact_v = input, paper_v = input;
    limit_h_shock(mesh, 1.5, exact);
    limit_h_variation(mesh, .4, exact_v);
    const PaperReduction shock = paper_h_shock(mesh, 1.5, paper), variation = paper_h_variation(mesh, .4, paper_v);
    CHECK(shock.converged);
    CHECK(variation.converged);
    CHECK(measure_gradation(mesh, paper).shock_max <= 1.5 * (1 + 1e-9));
    for (std::size_t v = 0; v < input.size(); ++v) {
        CHECK(paper[v] <= exact[v] * (1 + 1e-12));
        CHECK(paper_v[v] == Approx(exact_v[v]).epsilon(1e-13));
    }
    CHECK_FALSE(paper_h_shock(mesh, 1.5, paper = input, 1).converged);
}

TEST_CASE("Corrections refuse bounds and sizes out of range", "[gradation]") {
    const TriMesh mesh = grid(2, 2, 1).mesh();
    std::vector<double> size(9, 1);
    for (const double beta : {1., .5, -1., std::nan(""), double(INFINITY)}) {
        CHECK_THROWS_AS(limit_h_shock(mesh, beta, size), std::invalid_argument);
        CHECK_THROWS_AS(paper_h_shock(mesh, beta, size), std::invalid_argument);
    }
    for (const double bound : {0., -1., std::nan(""), double(INFINITY)}) {
        CHECK_THROWS_AS(limit_h_variation(mesh, bound, size), std::invalid_argument);
        CHECK_THROWS_AS(paper_h_variation(mesh, bound, size), std::invalid_argument);
    }
    size[4] = 0;
    CHECK_THROWS_WITH(limit_h_shock(mesh, 1.5, size), Catch::Contains("vertex 4"));
}
