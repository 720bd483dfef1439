#include "divide_curves.hpp"

#include "../assert.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace gradus {

namespace {

// Mean metric length of the edges of a mesh whose triangles have the areas asked for: theirs is a little above one
// where sizes grow.
constexpr double kMeanLength = 1.04;
constexpr double kLongestMerged = 2.2;  // metric length of two edges that become one, before the run is evened out
constexpr int kMostPasses = 8;          // of merging, or halving, and evening out
constexpr int kSweepsBetween = 6, kSweepsAtLast = 20;
constexpr double kEven = 0.02;  // moves over the size that end the evening out
constexpr int kApart = 4;       // edges between two that are merged, or halved, in one pass

// Vertices in a row along a feature curve; those between the ends slide.
struct Run {
    std::vector<int> vertices;
    bool slides_all_round = false;  // the last is the first, and slides too

    int num_edges() const { return static_cast<int>(vertices.size()) - 1; }
    bool returns() const { return vertices.front() == vertices.back(); }
};

template <class M>
std::vector<Run> list_runs(const EditorOf<M>& editor, const OptimiseOptions& options) {
    const Connectivity& mesh = editor.mesh();
    const auto slides = [&](int v) { return editor.vertex(v).bound == Bound::Curve && options.is_active(v); };
    // What slides has two; if it has not, the run ends there.
    const auto neighbours_on_curve = [&](int v) {
        std::array<int, 2> on_curve{-1, -1};
        int count = 0;
        mesh.for_each_edge(v, [&](int edge, int other) {
            if (mesh.tag(edge) >= 0 && count < 2) on_curve[count++] = other;
        });
        return on_curve;
    };
    std::vector<char> done(mesh.num_vertices());
    std::vector<Run> runs;
    for (int start = 0; start < mesh.num_vertices(); ++start) {
        if (done[start] || !mesh.is_live_vertex(start) || !slides(start)) continue;
        done[start] = 1;
        Run run{{start}};
        std::vector<int>& row = run.vertices;
        // Goes on from the last vertex of the row to the end of the curve, or round to the start.
        const auto go_on = [&](int next) {
            row.push_back(next);
            while (slides(row.back()) && row.back() != start) {
                done[row.back()] = 1;
                const auto [one, other] = neighbours_on_curve(row.back());
                if (other < 0) return;
                row.push_back(one == row[row.size() - 2] ? other : one);
            }
        };
        const auto [one, other] = neighbours_on_curve(start);
        if (other < 0) continue;
        go_on(one);
        run.slides_all_round = row.back() == start;
        if (!run.slides_all_round) {
            std::reverse(row.begin(), row.end());
            go_on(other);
        }
        runs.push_back(std::move(run));
    }
    return runs;
}

template <class M>
std::vector<double> lengths_of(const EditorOf<M>& editor, const Run& run) {
    std::vector<double> lengths;
    for (int i = 0; i < run.num_edges(); ++i) {
        const int edge = editor.mesh().find_edge(run.vertices[i], run.vertices[i + 1]);
        GRADUS_ASSERT(edge >= 0 && editor.mesh().tag(edge) >= 0);
        lengths.push_back(editor.length(edge));
    }
    return lengths;
}

template <class M>
void even_out(EditorOf<M>& editor, const Run& run, int sweeps) {
    const std::vector<int>& v = run.vertices;
    const int last = run.num_edges();
    double farthest = 1;
    for (int sweep = 0; sweep < sweeps && farthest > kEven; ++sweep) {
        farthest = run.slides_all_round ? editor.centre(v[0], v[last - 1], v[1]) : 0;
        for (int j = 1; j < last; ++j) {
            const int i = sweep % 2 == 0 ? j : last - j;
            farthest = std::max(farthest, editor.centre(v[i], v[i - 1], v[i + 1]));
        }
    }
}

// Places in a run, the best first, of which each that is taken bars those near it.
class Picks {
  public:
    explicit Picks(const Run& run) : is_near_(run.vertices.size()) {}
    void offer(double cost, int at) { candidates_.push_back({cost, at}); }

    // Calls take(place) for each that is not barred until `most` were taken. @returns how many
    template <class Take>
    int pick(int most, const Take& take) {
        std::sort(candidates_.begin(), candidates_.end());
        int taken = 0;
        for (const auto& [cost, at] : candidates_) {
            if (taken == most) break;
            if (is_near_[at] || !take(at)) continue;
            ++taken;
            for (int i = std::max(0, at - kApart); i <= std::min(at + kApart, static_cast<int>(is_near_.size()) - 1);
                 ++i)
                is_near_[i] = 1;
        }
        return taken;
    }

  private:
    std::vector<std::pair<double, int>> candidates_;
    std::vector<char> is_near_;
};

// Removes up to `most` vertices of the run, those between the shortest edges first. @returns how many
template <class M>
int merge_shortest(EditorOf<M>& editor, Run& run, int most) {
    const Connectivity& mesh = editor.mesh();
    const std::vector<double> lengths = lengths_of(editor, run);
    Picks picks(run);
    for (int i = 1; i < run.num_edges(); ++i)
        if (const double merged = lengths[i - 1] + lengths[i]; merged < kLongestMerged) picks.offer(merged, i);
    std::vector<int>& row = run.vertices;
    const auto collapse = [&](int from, int to) {
        const int h = mesh.find_edge(from, to);
        return mesh.origin(h) == from && editor.can_collapse(h) && editor.collapse(h, kLongestMerged);
    };
    const int merged = picks.pick(most, [&](int i) {
        if (!collapse(row[i], row[i - 1]) && !collapse(row[i], row[i + 1])) return false;
        row[i] = -1;
        return true;
    });
    std::erase(row, -1);
    return merged;
}

// Halves up to `most` edges of the run, the longest first. @returns how many
template <class M>
int halve_longest(EditorOf<M>& editor, Run& run, int most) {
    const std::vector<double> lengths = lengths_of(editor, run);
    Picks picks(run);
    for (int i = 0; i < run.num_edges(); ++i) picks.offer(-lengths[i], i);
    std::vector<int> middles(lengths.size(), -1);
    const int halved = picks.pick(most, [&](int i) {
        middles[i] = editor.split(editor.mesh().find_edge(run.vertices[i], run.vertices[i + 1]));
        return middles[i] >= 0;
    });
    std::vector<int> row{run.vertices[0]};
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        if (middles[i] >= 0) row.push_back(middles[i]);
        row.push_back(run.vertices[i + 1]);
    }
    run.vertices = std::move(row);
    return halved;
}

}  // namespace

template <class M>
void divide_curves(EditorOf<M>& editor, const OptimiseOptions& options, OptimiseReport& report) {
    for (Run& run : list_runs(editor, options)) {
        double length = 0;
        for (const double l : lengths_of(editor, run)) length += l;
        const int wanted = std::max(run.returns() ? 3 : 1, static_cast<int>(std::lround(length / kMeanLength)));
        bool changed = false;
        for (int pass = 0; pass < kMostPasses && run.num_edges() != wanted; ++pass) {
            const int surplus = run.num_edges() - wanted;
            const int done = surplus > 0 ? merge_shortest(editor, run, surplus) : halve_longest(editor, run, -surplus);
            if (done == 0) break;
            (surplus > 0 ? report.collapses : report.splits) += done;
            even_out(editor, run, kSweepsBetween);
            changed = true;
        }
        if (changed) even_out(editor, run, kSweepsAtLast);
    }
}

template void divide_curves(EditorOf<Size>& editor, const OptimiseOptions& options, OptimiseReport& report);
template void divide_curves(EditorOf<SizeTensor>& editor, const OptimiseOptions& options, OptimiseReport& report);

}  // namespace gradus
