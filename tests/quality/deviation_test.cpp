// The proof that goes from mesh to mesh, against the plain measure that remembers nothing.
#include "gradus/quality/deviation.hpp"

#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>

#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

// A surface that meshes are made over.
struct Base {
    Mesh mesh;
    Connectivity connectivity{static_cast<int>(mesh.points.size()), mesh.triangles};
    DistanceTarget target{mesh.view()};

    explicit Base(Mesh given) : mesh(std::move(given)) {}
    ReferenceView view() const { return {mesh.view(), connectivity}; }
    std::vector<int> under(const Mesh& over) const {
        std::vector<int> under;
        for (const Vector3d& p : over.points) under.push_back(target.closest(p).triangle);
        return under;
    }
};

double wave(double x, double y) { return 0.1 * std::sin(5 * x) * std::cos(4 * y); }
double ripple(double x, double y) { return 0.02 * wave(x, y); }

struct Case {
    Mesh surface, mesh;
};
Case case_of(int kind) {
    if (kind == 0) return {triangulations::sphere(4), triangulations::sphere(3, 1, 0.12, 21)};
    if (kind == 1) return {triangulations::torus(40, 16), triangulations::torus(26, 12, 3, 1, 0.12, 5)};
    if (kind == 2) return {triangulations::graph(20, wave), triangulations::graph(13, wave, 0.2, 3)};
    // A surface of triangles much larger than the mesh's.
    return {triangulations::graph(3, ripple), triangulations::graph(30, ripple, 0.2, 3)};
}

// Moves the vertices of one place, splits an edge or changes nothing; numbers change with it.
Mesh changed(const Mesh& mesh, std::mt19937& random, double size) {
    const auto any = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    Mesh next = mesh;
    switch (random() % 4) {
        case 0:
            break;
        case 1: {
            const Vector3d place = mesh.points[any(mesh.points.size())];
            std::uniform_real_distribution<double> offset(-0.3 * size, 0.3 * size);
            for (Vector3d& p : next.points)
                if ((p - place).norm() < 1.5 * size) p += Vector3d(offset(random), offset(random), offset(random));
            break;
        }
        default: {
            const Triangle split = mesh.triangles[any(mesh.triangles.size())];
            const int a = split[0], b = split[1], m = static_cast<int>(mesh.points.size());
            next.points.push_back((mesh.points[a] + mesh.points[b]) / 2 + Vector3d(0, 0, 0.1 * size));
            next.triangles.clear();
            for (const Triangle& t : mesh.triangles) {
                const auto ia = std::find(t.begin(), t.end(), a), ib = std::find(t.begin(), t.end(), b);
                if (ia == t.end() || ib == t.end()) {
                    next.triangles.push_back(t);
                    continue;
                }
                Triangle without_a = t, without_b = t;
                without_a[ia - t.begin()] = m;
                without_b[ib - t.begin()] = m;
                next.triangles.push_back(without_a);
                next.triangles.push_back(without_b);
            }
        }
    }
    return testing::relabelled(next, static_cast<unsigned>(random()));
}

// Triangles of which a point beyond the limit is known.
std::set<int> seen_beyond(const OneSidedDistance& d, double limit) {
    std::set<int> seen;
    for (const TooFar& f : d.beyond)
        if (f.distance > limit) seen.insert(f.triangle);
    return seen;
}

// Those, and those that are not proved to keep the limit though no such point is known.
std::set<int> all_beyond(const OneSidedDistance& d) {
    std::set<int> all;
    for (const TooFar& f : d.beyond) all.insert(f.triangle);
    return all;
}

// What is proved with a memory is what is measured without one.
void check_same(const OneSidedDistance& proved, const OneSidedDistance& plain, double largest, double limit) {
    CHECK(seen_beyond(proved, limit) == seen_beyond(plain, limit));
    CHECK(all_beyond(proved) == all_beyond(plain));
    CHECK((proved.bound <= limit) == (plain.bound <= limit));
    CHECK(proved.bound >= largest);
    CHECK(proved.largest <= proved.bound);
}

}  // namespace

TEST_CASE("a proof from mesh to mesh finds what the plain measure finds of each", "[property]") {
    const int kind = GENERATE(0, 1, 2, 3);
    const double share = GENERATE(0.5, 0.95, 1.2);
    const unsigned seed = GENERATE(1u, 2u);
    CAPTURE(kind, share, seed);
    Case made = case_of(kind);
    const Base base(made.surface);
    Mesh mesh = made.mesh;
    const double size = triangulations::mean_edge(mesh),
                 limit = share * measure_deviation(base.view(), mesh.view(), base.under(mesh)).largest();
    DeviationProof proof(base.view(), limit);
    std::mt19937 random(seed);
    int kept = 0, not_kept = 0;
    for (int round = 0; round < 8; ++round, mesh = changed(round % 3 ? mesh : made.mesh, random, size)) {
        CAPTURE(round);
        const ProvedDeviation proved = proof.prove(mesh.view(), base.under(mesh));
        const DistanceTarget over(mesh.view());
        const double from_mesh = base.target.measure_from(mesh.view(), {.precision = 1e-3}).largest,
                     from_reference = over.measure_from(base.mesh.view(), {.precision = 1e-3}).largest;
        check_same(proved.deviation.from_mesh, base.target.measure_from(mesh.view(), {.limit = limit}), from_mesh,
                   limit);
        check_same(proved.deviation.from_reference, over.measure_from(base.mesh.view(), {.limit = limit}),
                   from_reference, limit);
        CHECK(proved.at_fault.empty() == (std::max(from_mesh, from_reference) <= limit));
        for (const TooFar& f : proved.at_fault) CHECK((f.triangle >= 0 && f.triangle < std::ssize(mesh.triangles)));
        ++(proved.at_fault.empty() ? kept : not_kept);
    }
    // The changes are such that both come about where the first mesh is within the limit.
    CHECK(not_kept > 0);
    CHECK((share < 1 || kept > 0));
}

TEST_CASE("a mesh that is proved again has the bound it had", "[exact]") {
    const Case made = case_of(0);
    const Base base(made.surface);
    DeviationProof proof(base.view(), 1);
    const Deviation first = proof.prove(made.mesh.view(), base.under(made.mesh)).deviation;
    const Mesh other = testing::relabelled(made.mesh, 4);
    const Deviation again = proof.prove(other.view(), base.under(other)).deviation;
    CHECK(again.bound() == first.bound());
    CHECK(first.bound() < 1);
}

TEST_CASE("a mesh of which a part is removed does not keep the limit, and is said to where it was", "[property]") {
    for (const int kind : {0, 1, 2, 3}) {
        CAPTURE(kind);
        const Case made = case_of(kind);
        const Base base(made.surface);
        const double size = triangulations::mean_edge(made.mesh);
        const double limit = 1.5 * measure_deviation(base.view(), made.mesh.view(), base.under(made.mesh)).bound();
        DeviationProof proof(base.view(), limit);
        REQUIRE(proof.prove(made.mesh.view(), base.under(made.mesh)).at_fault.empty());
        const Vector3d place = made.mesh.points[made.mesh.triangles[made.mesh.triangles.size() / 2][0]];
        Mesh open = made.mesh;
        std::erase_if(open.triangles, [&](const Triangle& t) {
            return std::any_of(t.begin(), t.end(), [&](int v) { return (open.points[v] - place).norm() < 1.5 * size; });
        });
        REQUIRE(open.triangles.size() < made.mesh.triangles.size());
        const ProvedDeviation proved = proof.prove(open.view(), base.under(open));
        CHECK(proved.deviation.from_mesh.beyond.empty());
        CHECK_FALSE(proved.deviation.from_reference.beyond.empty());
        CHECK(proved.deviation.bound() > limit);
        CHECK_FALSE(proved.at_fault.empty());
        CHECK((proved.deviation.from_reference.point - place).norm() < 4 * size);
        // Whole again.
        CHECK(proof.prove(made.mesh.view(), base.under(made.mesh)).at_fault.empty());
    }
}

TEST_CASE("triangles under vertices that are not known, or far from them, change no verdict", "[property]") {
    const Case made = case_of(1);
    const Base base(made.surface);
    const double limit = measure_deviation(base.view(), made.mesh.view(), base.under(made.mesh)).bound();
    const std::vector<int> none(made.mesh.points.size(), -1), first(made.mesh.points.size(), 0);
    for (const double share : {0.7, 1.1})
        for (const auto& under : {none, first})
            CHECK(DeviationProof(base.view(), share * limit).prove(made.mesh.view(), under).at_fault.empty() ==
                  (share > 1));
}

TEST_CASE("a deviation is no less than that of samples, and proofs name what is wrong with them", "[property]") {
    const Case made = case_of(0);
    const Base base(made.surface);
    const Deviation d = measure_deviation(base.view(), made.mesh.view(), base.under(made.mesh), 1e-3);
    CHECK(d.bound() <= 1.001 * d.largest());
    for (const Vector3d& p : made.mesh.points) CHECK(base.target.distance(p) <= d.from_mesh.bound);
    CHECK_THROWS_AS(DeviationProof(base.view(), 0), std::invalid_argument);
    CHECK_THROWS_AS(measure_deviation(base.view(), made.mesh.view(), {}), std::invalid_argument);
    CHECK_THROWS_AS(DeviationProof(base.view(), 1).prove(made.mesh.view(), {}), std::invalid_argument);
}

namespace {

// The triangles at a vertex, and after them those that touch them.
struct Part {
    Mesh mesh;
    int changed = 0;
    std::vector<int> vertex;  // of the whole mesh
};
Part part_at(const Mesh& mesh, int v) {
    Part part;
    std::vector<int> chosen;
    std::set<int> near;
    const auto has = [](const Triangle& t, int vertex) { return std::find(t.begin(), t.end(), vertex) != t.end(); };
    for (int t = 0; t < std::ssize(mesh.triangles); ++t)
        if (has(mesh.triangles[t], v))
            chosen.push_back(t), near.insert(mesh.triangles[t].begin(), mesh.triangles[t].end());
    part.changed = static_cast<int>(chosen.size());
    for (int t = 0; t < std::ssize(mesh.triangles); ++t)
        if (!has(mesh.triangles[t], v) &&
            std::any_of(near.begin(), near.end(), [&](int x) { return has(mesh.triangles[t], x); }))
            chosen.push_back(t);
    std::map<int, int> number;
    for (const int t : chosen) {
        Triangle own = mesh.triangles[t];
        for (int& x : own) {
            const auto [it, is_new] = number.try_emplace(x, static_cast<int>(part.vertex.size()));
            if (is_new) part.vertex.push_back(x), part.mesh.points.push_back(mesh.points[x]);
            x = it->second;
        }
        part.mesh.triangles.push_back(own);
    }
    return part;
}

}  // namespace

TEST_CASE("a part of a mesh keeps the limit where the mesh does, and not where a vertex of either surface sticks out",
          "[property]") {
    const Case made = case_of(0);
    Mesh surface = made.surface;
    double deviation = 0;
    {
        const Base base(surface);
        deviation = measure_deviation(base.view(), made.mesh.view(), base.under(made.mesh)).bound();
    }
    const double limit = 1.05 * deviation;
    // One vertex of the surface is pulled out.
    const int spike = 100;
    surface.points[spike] *= 1 + 3 * limit;
    const Base base(surface);
    DeviationProof proof(base.view(), limit);
    int beside_spike = 0;
    for (int v = 0; v < std::ssize(made.mesh.points); v += 7) {
        CAPTURE(v);
        Part part = part_at(made.mesh, v);
        const bool under_spike = DistanceTarget({part.mesh.points, std::span(part.mesh.triangles).first(part.changed)})
                                     .distance(surface.points[spike]) <
                                 DistanceTarget(made.mesh.view()).distance(surface.points[spike]) * (1 + 1e-12);
        beside_spike += under_spike;
        const bool near_spike = (made.mesh.points[v] - surface.points[spike]).norm() < 0.5;
        if (!near_spike || under_spike)
            CHECK(proof.is_kept_by(part.mesh.view(), part.changed, base.under(part.mesh)) == !under_spike);
        if (near_spike) continue;
        // A point that is asked for counts wherever it is.
        CHECK(proof.is_kept_by(part.mesh.view(), part.changed, base.under(part.mesh), part.mesh.points[0]));
        CHECK_FALSE(proof.is_kept_by(part.mesh.view(), part.changed, base.under(part.mesh), 2 * part.mesh.points[0]));
        const int own = static_cast<int>(std::find(part.vertex.begin(), part.vertex.end(), v) - part.vertex.begin());
        for (const double push : {3.0, -3.0}) {
            Mesh pushed = part.mesh;
            pushed.points[own] *= 1 + push * limit;
            CHECK_FALSE(proof.is_kept_by(pushed.view(), part.changed, base.under(pushed)));
        }
    }
    CHECK(beside_spike <= 3);
    // That one was looked at.
    const DistanceTarget over(made.mesh.view());
    const int under = made.mesh.triangles[over.closest(surface.points[spike]).triangle][0];
    const Part part = part_at(made.mesh, under);
    CHECK_FALSE(proof.is_kept_by(part.mesh.view(), part.changed, base.under(part.mesh)));
}
