#include "patch_meshes.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "gradus/plane/delaunay.hpp"

namespace gradus {

namespace {

constexpr double kTarget =
    1.01;  // lengths asked of the generator, whose edges come out somewhat short where the metric varies
constexpr int kRepairRounds = 20;

// Cuts edge (a, b) of a patch mesh in its middle.
void cut_edge(PatchMesh& mesh, int a, int b) {
    const int m = static_cast<int>(mesh.uv.size());
    mesh.uv.push_back((mesh.uv[a] + mesh.uv[b]) / 2);
    mesh.cell.push_back(mesh.cell[a]);
    mesh.number.push_back(-1);
    const std::size_t before = mesh.triangles.size();
    for (std::size_t t = 0; t < before; ++t)
        for (int k = 0; k < 3; ++k) {
            auto& v = mesh.triangles[t];
            const int x = v[k], y = v[(k + 1) % 3], z = v[(k + 2) % 3];
            if ((x == a && y == b) || (x == b && y == a)) {
                v = {x, m, z};
                mesh.triangles.push_back({m, y, z});
                break;
            }
        }
}

void split_in_middle(PatchMesh& mesh, int t) {
    const auto [a, b, c] = mesh.triangles[t];
    const int m = static_cast<int>(mesh.uv.size());
    mesh.uv.push_back((mesh.uv[a] + mesh.uv[b] + mesh.uv[c]) / 3);
    mesh.cell.push_back(mesh.cell[a]);
    mesh.number.push_back(-1);
    mesh.triangles[t] = {a, b, m};
    mesh.triangles.push_back({b, c, m});
    mesh.triangles.push_back({c, a, m});
}

struct EdgeUse {
    std::array<int, 2> ends;  // global numbers, in the direction of the triangle
    int patch;
    std::array<int, 2> local;
};

}  // namespace

CutCurves::CutCurves(const SurfaceModel& model, std::vector<std::vector<double>> parameters)
    : t(std::move(parameters)), count(static_cast<int>(model.vertices().size())) {
    for (std::size_t c = 0; c < t.size(); ++c) {
        first.push_back(count);
        if (model.curves()[c].kind != CurveKind::Pole) count += std::max(0, static_cast<int>(t[c].size()) - 2);
    }
}

int CutCurves::number(const SurfaceModel& model, int curve, int i) const {
    const int last = static_cast<int>(t[curve].size()) - 1;
    return i == 0 ? model.curves()[curve].ends[0] : i == last ? model.curves()[curve].ends[1] : first[curve] + i - 1;
}

void cut_into_polygons(const SurfaceModel& model, std::vector<int>& pieces) {
    std::map<std::pair<int, int>, int> straight;  // curves of one piece between two vertices
    for (std::size_t c = 0; c < pieces.size(); ++c) {
        const ModelCurve& curve = model.curves()[c];
        if (curve.kind == CurveKind::Pole) continue;
        const auto [a, b] = std::minmax(curve.ends[0], curve.ends[1]);
        const bool seam = curve.uses.size() == 2 && curve.uses[0].patch == curve.uses[1].patch;
        pieces[c] = std::max(a == b ? 3 : seam ? 2 : 1, pieces[c]);
        if (pieces[c] == 1 && ++straight[{a, b}] > 1) pieces[c] = 2;
    }
}

std::vector<double> equal_pieces(std::span<const double> t, std::span<const double> length, int pieces) {
    std::vector<double> cut{0};
    std::size_t i = 1;
    for (int k = 1; k < pieces; ++k) {
        const double wanted = length.back() * k / pieces;
        while (i + 1 < t.size() && length[i] < wanted) ++i;
        const double l0 = length[i - 1], l1 = length[i];
        const double s = l1 > l0 ? (wanted - l0) / (l1 - l0) : 0.5;
        cut.push_back(t[i - 1] + s * (t[i] - t[i - 1]));
    }
    cut.push_back(t.back());
    return cut;
}

PatchMeshes::PatchMeshes(const SurfaceModel& model, const CutCurves& curves, const PatchSize& size,
                         std::size_t most_points)
    : model_(model), patches_(model.num_patches()), shared_(curves.count), count_(curves.count) {
    tbb::parallel_for(0, model.num_patches(), [&](int p) { patches_[p] = mesh_patch(p, curves, size, most_points); });
    for (PatchMesh& mesh : patches_) number_inner(mesh);
    split_twin_triangles();
    for (int round = 0; round < kRepairRounds && cut_conflicts(); ++round) {
    }
}

std::vector<Triangle> PatchMeshes::triangles() const {
    std::vector<Triangle> all;
    for_each_triangle([&](int p, const std::array<int, 3>& t) {
        const std::vector<int>& number = patches_[p].number;
        all.push_back({number[t[0]], number[t[1]], number[t[2]]});
    });
    return all;
}

PatchMesh PatchMeshes::mesh_patch(int p, const CutCurves& curves, const PatchSize& size,
                                  std::size_t most_points) const {
    const SurfaceModel& model = model_;
    PatchMesh result;
    PlanarDomain domain;
    const auto add = [&](const SurfacePoint& at, int number) {
        domain.points.push_back(at.uv);
        result.number.push_back(number);
    };
    std::vector<std::size_t> poles;  // segments
    // Once around each loop: every use without its last point. A pole that is not cut is one segment.
    for (const std::vector<UseRef>& loop : model.loops(p)) {
        const int first = static_cast<int>(domain.points.size());
        for (const UseRef& ref : loop) {
            const auto [c, u] = ref;
            const bool reversed = model.use(ref).reversed;
            add(model.on_curve(c, u, reversed ? 1 : 0), model.start_of(ref));
            const bool is_pole = model.curves()[c].kind == CurveKind::Pole;
            if (is_pole) poles.push_back(domain.points.size() - 1);
            const int last = static_cast<int>(curves.t[c].size()) - 1;
            for (int k = 1; k < last; ++k) {
                const int i = reversed ? last - k : k;
                if (is_pole) poles.push_back(domain.points.size());
                add(model.on_curve(c, u, curves.t[c][i]), is_pole ? model.start_of(ref) : curves.number(model, c, i));
            }
        }
        const int end = static_cast<int>(domain.points.size());
        for (int i = first; i < end; ++i) domain.segments.push_back({i, i + 1 < end ? i + 1 : first});
    }
    for (const std::size_t pole : poles) result.poles.push_back(domain.segments[pole]);

    const ParametricSurface& patch = model.patch(p);
    const PlaneMetric metric = [&](const Eigen::Vector2d& uv, int& hint) {
        const Jet1 jet = patch.jet1(uv);
        const double h = size({p, uv}, jet.p, hint);
        const double F = jet.du.dot(jet.dv);
        Eigen::Matrix2d M;
        M << jet.du.squaredNorm(), F, F, jet.dv.squaredNorm();
        return Eigen::Matrix2d(M / (h * h));
    };
    PlanarMesh planar = mesh_domain(domain, metric, {.target = kTarget, .max_points = most_points});
    result.uv = std::move(planar.points);
    result.cell = std::move(planar.hints);
    result.triangles = std::move(planar.triangles);
    result.number.resize(result.uv.size(), -1);
    return result;
}

void PatchMeshes::number_inner(PatchMesh& mesh) {
    for (int& number : mesh.number)
        if (number < 0) number = count_++;
}

bool PatchMeshes::is_pole(int p, int a, int b) const {
    return std::any_of(patches_[p].poles.begin(), patches_[p].poles.end(), [&](const std::array<int, 2>& pole) {
        return (pole[0] == a && pole[1] == b) || (pole[0] == b && pole[1] == a);
    });
}

bool PatchMeshes::cut_conflicts() {
    std::vector<EdgeUse> uses, conflicts;
    for (int p = 0; p < static_cast<int>(patches_.size()); ++p) {
        const PatchMesh& mesh = patches_[p];
        const bool flipped = model_.flipped(p);
        for (const auto& t : mesh.triangles) {
            bool vanishes = false;
            for (int k = 0; k < 3; ++k) {
                const int a = t[k], b = t[(k + 1) % 3];
                if (mesh.number[a] != mesh.number[b]) continue;
                vanishes = true;
                if (!is_pole(p, a, b)) conflicts.push_back({{mesh.number[a], mesh.number[b]}, p, {a, b}});
            }
            if (vanishes) continue;
            for (int k = 0; k < 3; ++k) {
                int a = t[k], b = t[(k + 1) % 3];
                // Only vertices on curves are in several places.
                if (mesh.number[a] >= shared_ && mesh.number[b] >= shared_) continue;
                if (flipped) std::swap(a, b);
                uses.push_back({{mesh.number[a], mesh.number[b]}, p, {a, b}});
            }
        }
    }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& x, const EdgeUse& y) {
        return std::tie(x.ends, x.patch, x.local) < std::tie(y.ends, y.patch, y.local);
    });
    const auto inside = [&](const EdgeUse& e) {
        // On the border of its patch an edge has one triangle there: it has no twin with the same local ends.
        const std::array<int, 2> back{e.ends[1], e.ends[0]}, local{e.local[1], e.local[0]};
        const auto first =
            std::lower_bound(uses.begin(), uses.end(), back,
                             [](const EdgeUse& x, const std::array<int, 2>& ends) { return x.ends < ends; });
        for (auto i = first; i != uses.end() && i->ends == back; ++i)
            if (i->patch == e.patch && i->local == local) return true;
        return false;
    };
    for (std::size_t i = 0; i < uses.size();) {
        std::size_t j = i;
        while (j < uses.size() && uses[j].ends == uses[i].ends) ++j;
        if (j - i > 1)
            for (std::size_t k = i; k < j; ++k)
                if (inside(uses[k])) conflicts.push_back(uses[k]);
        i = j;
    }
    if (conflicts.empty()) return false;
    std::vector<std::pair<int, std::array<int, 2>>> cut;
    for (const EdgeUse& e : conflicts)
        cut.push_back({e.patch, {std::min(e.local[0], e.local[1]), std::max(e.local[0], e.local[1])}});
    std::sort(cut.begin(), cut.end());
    cut.erase(std::unique(cut.begin(), cut.end()), cut.end());
    for (const auto& [p, ends] : cut) {
        cut_edge(patches_[p], ends[0], ends[1]);
        number_inner(patches_[p]);
    }
    return true;
}

// Two triangles on the same three vertices enclose nothing: each gets a point in its middle. Only corners that
// patches share can be those of two triangles, and these are numbered first.
void PatchMeshes::split_twin_triangles() {
    std::map<std::array<int, 3>, std::vector<std::pair<int, int>>> by_corners;  // patch and triangle
    for (int p = 0; p < static_cast<int>(patches_.size()); ++p)
        for (int t = 0; t < static_cast<int>(patches_[p].triangles.size()); ++t) {
            const auto& v = patches_[p].triangles[t];
            const auto& number = patches_[p].number;
            std::array<int, 3> corners{number[v[0]], number[v[1]], number[v[2]]};
            std::sort(corners.begin(), corners.end());
            if (corners[0] < corners[1] && corners[1] < corners[2] && corners[2] < shared_)
                by_corners[corners].emplace_back(p, t);
        }
    for (const auto& [corners, uses] : by_corners)
        if (uses.size() > 1)
            for (const auto& [p, t] : uses) {
                split_in_middle(patches_[p], t);
                number_inner(patches_[p]);
            }
}

}  // namespace gradus
