#include "optimise.hpp"

#include "divide_curves.hpp"

#include <fmt/format.h>

#include <deque>
#include <map>
#include <numbers>
#include <queue>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr double kLongest = std::numbers::sqrt2;  // metric lengths between which an edge counts as unit
constexpr double kShortest = 1 / std::numbers::sqrt2;
constexpr double kValenceWorth = 0.15;  // energy that one unit of valence penalty is worth to a flip
constexpr int kFitRounds = 2, kMostFitRounds = 5;
constexpr double kFarTooLong =
    2;  // metric length of edges for which rounds go on: sizes far below the triangles that were given
constexpr int kMostSplitPasses = 40, kMostCollapsePasses = 40;
constexpr double kMostGrowth = 2;  // of the triangles there are, or are predicted, by splitting
constexpr double kFlat = 0.02;  // height over the size, of flips that do not leave the surface however long the edges
constexpr int kFlipsPerEdge = 10;
constexpr double kAttemptsPerVertex = 12;  // bound on the attempts for the mean
// Bounds on the search for better worst triangles, in moves of a vertex; without them a map that jumps keeps it busy
// for minutes.
constexpr long kMovesPerVertex = 20, kMovesByLastResortsPerVertex = 10, kMovesAtLeast = 20'000;
constexpr long kMovesByPairs = 5000;  // of one triangle
constexpr int kWorstRounds = 12;
// Rise of the energy, before anything moves, up to which a flip is tried, and what is added for each unit by which the
// valence penalty falls. Of flips above it one of twenty is kept.
constexpr double kHopefulFlip = 0.8, kHopefulPerGain = 0.1;
constexpr double kFarBelow = 0.02;      // triangles this far below the goal are worth pairs of operations, and pushes
constexpr double kStretched = 0.96;     // triangles of a regular mesh are better than this
constexpr double kMuchStretched = 0.1;  // of the triangles
constexpr double kPoor = 0.8;           // triangles below this are moved for their own sake by the fast schedule
constexpr double kVeryBad = 0.04;       // and this far below, of a wider search
constexpr double kWidestFan = 2.3;   // ratio of edges at a vertex up to which its triangles are as good as their shape
constexpr double kLeastSize = 1e-9;  // over the coordinates: elements that small have shapes to seven digits
constexpr double kSameQuality = 0.01;  // a triangle that changed less is not tried again

struct LengthAt {
    double length;
    int halfedge;
};

// Metric lengths of the edges that are wanted: longer than, or shorter than, a limit.
enum class Wanted { Long, Short };
template <class M>
class EdgesByLength {
  public:
    EdgesByLength(const EditorOf<M>& editor, const OptimiseOptions& options, Wanted wanted, double limit)
        : editor_(editor), options_(options), wanted_(wanted), limit_(limit) {}

    // All of them, from the longest or the shortest on.
    const std::vector<LengthAt>& list() {
        edges_.clear();
        for (int h = 0; h < 3 * editor_.mesh().num_triangles(); ++h)
            if (editor_.mesh().is_live_triangle(h / 3)) offer(h);
        sort();
        return edges_;
    }

    // The same after operations that changed no others than those of the triangles at some vertices.
    const std::vector<LengthAt>& list_again(const std::vector<int>& changed) {
        before_.swap(edges_);
        edges_.clear();
        for (const LengthAt& e : before_)
            if (editor_.mesh().is_live_triangle(e.halfedge / 3)) offer(e.halfedge);
        for (const int v : changed)
            if (editor_.mesh().is_live_vertex(v))
                editor_.mesh().for_each_outgoing(v, [&](int h) {
                    for (const int e : {h, Connectivity::next(h), Connectivity::prev(h)}) offer(canonical(e));
                });
        sort();
        const auto is_same = [](const LengthAt& a, const LengthAt& b) { return a.halfedge == b.halfedge; };
        edges_.erase(std::unique(edges_.begin(), edges_.end(), is_same), edges_.end());
        return edges_;
    }

  private:
    int canonical(int h) const {
        const int g = editor_.mesh().twin(h);
        return g >= 0 ? std::min(g, h) : h;
    }

    void offer(int h) {
        const Connectivity& mesh = editor_.mesh();
        if (canonical(h) != h || !(options_.is_active(mesh.origin(h)) || options_.is_active(mesh.target(h)))) return;
        // Cheap tests before the length.
        const bool is_long = wanted_ == Wanted::Long;
        if (is_long ? editor_.is_frozen(h) || editor_.longest_length(h) <= limit_
                    : editor_.shortest_length(h) >= limit_)
            return;
        const double length = editor_.length(h);
        if (is_long ? length > limit_ : length < limit_) edges_.push_back({length, h});
    }

    void sort() {
        const double sign = wanted_ == Wanted::Long ? -1 : 1;
        std::sort(edges_.begin(), edges_.end(), [sign](const LengthAt& a, const LengthAt& b) {
            return std::pair(sign * a.length, a.halfedge) < std::pair(sign * b.length, b.halfedge);
        });
    }

    const EditorOf<M>& editor_;
    const OptimiseOptions& options_;
    Wanted wanted_;
    double limit_;
    std::vector<LengthAt> edges_, before_;
};

// Flips while energy plus weighted valence penalty falls: each flip lowers it, so this ends; the bound is for rounding.
template <class M>
int flip_edges(EditorOf<M>& editor, const OptimiseOptions& options,
               double highest = std::numeric_limits<double>::infinity()) {
    const Connectivity& mesh = editor.mesh();
    const int halfedges = 3 * mesh.num_triangles();
    std::vector<int> queue;
    std::vector<char> queued(halfedges, 0);
    for (int h = 0; h < halfedges; ++h)
        if (mesh.is_live_triangle(h / 3) && mesh.twin(h) > h &&
            (options.is_active(mesh.origin(h)) || options.is_active(mesh.target(h))))
            queue.push_back(h), queued[h] = 1;
    int flips = 0;
    const long most_flips = static_cast<long>(kFlipsPerEdge) * halfedges / 2;
    for (std::size_t i = 0; i < queue.size() && flips < most_flips; ++i) {
        const int h = queue[i];
        queued[h] = 0;
        if (!editor.can_flip(h) || (std::isfinite(highest) && editor.flip_height(h) > highest)) continue;
        const double most = kValenceWorth * editor.flip_gain(h) - 1e-9;
        if (editor.flip_rise(h, most) >= most || !editor.flip(h)) continue;
        ++flips;
        const int g = mesh.twin(Connectivity::next(h));
        for (const int e : {h, Connectivity::prev(h), Connectivity::next(g), Connectivity::prev(g)}) {
            const int edge = std::max(e, mesh.twin(e)) == e && mesh.twin(e) >= 0 ? mesh.twin(e) : e;
            if (mesh.twin(edge) >= 0 && !queued[edge]) queued[edge] = 1, queue.push_back(edge);
        }
    }
    return flips;
}

// Triangles that the sizes ask for where the mesh is worked at.
template <class M>
double predicted_triangles(const EditorOf<M>& editor, const OptimiseOptions& options) {
    double sum = 0;
    for (int t = 0; t < editor.mesh().num_triangles(); ++t) {
        if (!editor.mesh().is_live_triangle(t)) continue;
        const Triangle v = editor.mesh().triangle(t);
        if (options.is_active(v[0]) || options.is_active(v[1]) || options.is_active(v[2])) sum += editor.unit_area(t);
    }
    return sum;
}

// Halves the edges that are too long, the longest first; where some are much too long, as those of needles are, flips
// between the passes.
template <class M>
void split_long(EditorOf<M>& editor, const OptimiseOptions& options, OptimiseReport& report) {
    EdgesByLength long_edges(editor, options, Wanted::Long, kLongest);
    double longer_than = std::numeric_limits<double>::infinity();
    const double most = editor.mesh().num_live_triangles() + kMostGrowth * predicted_triangles(editor, options);
    std::vector<int> middles;
    for (int pass = 0; pass < kMostSplitPasses; ++pass) {
        const bool again = longer_than == kLongest;
        const std::vector<LengthAt>& edges = again ? long_edges.list_again(middles) : long_edges.list();
        // Where a split leads to sizes ever smaller the mesh would grow without end.
        if (edges.empty() || editor.mesh().num_live_triangles() > most) break;
        longer_than = std::max(kLongest, std::min(longer_than, edges.front().length) / 2);
        middles.clear();
        for (const LengthAt& e : edges) {
            const int middle =
                e.length > longer_than && editor.length(e.halfedge) > longer_than ? editor.split(e.halfedge) : -1;
            if (middle >= 0) middles.push_back(middle);
        }
        report.splits += static_cast<int>(middles.size());
        if (longer_than > kLongest)
            report.flips += flip_edges(editor, options, kFlat);
        else if (again && middles.empty())
            break;
    }
}

// Collapses the edges that are too short, the shortest first.
template <class M>
int collapse_short(EditorOf<M>& editor, const OptimiseOptions& options) {
    const Connectivity& mesh = editor.mesh();
    EdgesByLength short_edges(editor, options, Wanted::Short, kShortest);
    const auto collapse = [&](int h) { return editor.can_collapse(h) && editor.collapse(h); };
    int collapses = 0;
    std::vector<int> kept;
    for (int pass = 0; pass < kMostCollapsePasses; ++pass) {
        const std::vector<LengthAt>& edges = pass == 0 ? short_edges.list() : short_edges.list_again(kept);
        kept.clear();
        for (const LengthAt& e : edges) {
            if (!mesh.is_live_triangle(e.halfedge / 3) || editor.length(e.halfedge) >= kShortest) continue;
            int h = e.halfedge, g = mesh.twin(h);
            if (g >= 0 && editor.collapse_gain(g) > editor.collapse_gain(h)) std::swap(h, g);
            const int origin = mesh.origin(h), target = mesh.target(h);
            if (collapse(h))
                kept.push_back(target);
            else if (g >= 0 && collapse(g))
                kept.push_back(origin);
        }
        collapses += static_cast<int>(kept.size());
        if (kept.empty()) break;
    }
    return collapses;
}

template <class M>
void smooth(EditorOf<M>& editor, const OptimiseOptions& options, int sweeps) {
    const Connectivity& mesh = editor.mesh();
    // Moves over the size that wake the neighbours, and those where the mesh is not worked at: what was proved there is
    // not to change for little.
    constexpr double kRestless = 0.01, kVeryRestless = 0.02;
    std::vector<char> awake(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) awake[v] = options.is_active(v);
    for (int sweep = 0; sweep < sweeps; ++sweep)
        for (int v = 0; v < mesh.num_vertices(); ++v) {
            if (!awake[v] || !mesh.is_live_vertex(v)) continue;
            awake[v] = 0;
            const double moved = editor.relax(v);
            if (moved < kRestless) continue;
            const auto wake = [&](int w) { awake[w] = awake[w] || moved > kVeryRestless || options.is_active(w); };
            mesh.for_each_outgoing(v, [&](int h) { wake(mesh.target(h)), wake(mesh.apex(h)); });
        }
}

template <class M>
double mean_energy(const EditorOf<M>& editor) {
    double sum = 0;
    int count = 0;
    for (int t = 0; t < editor.mesh().num_triangles(); ++t)
        if (editor.mesh().is_live_triangle(t) && !editor.is_frozen_triangle(t)) sum += editor.energy(t), ++count;
    return sum / std::max(count, 1);
}

bool irregular(const Connectivity& mesh, int v) {
    return mesh.is_live_vertex(v) && mesh.valence(v) != (mesh.is_boundary_vertex(v) ? 4 : 6);
}

// Flips that worsen valences, or the energy by much before anything moves, are next to never kept.
// @param most_per_gain  added to `most` for each unit by which the valence penalty falls
template <class M>
bool worth_a_flip(const EditorOf<M>& editor, int h, double most, double most_per_gain) {
    if (!editor.can_flip(h)) return false;
    const int gain = editor.flip_gain(h);
    return gain >= 0 && editor.flip_rise(h) < most + gain * most_per_gain;
}

// Tries the operations around irregular vertices, and again around each that was kept.
template <class M>
void attempt_for_mean(EditorOf<M>& editor, const OptimiseOptions& options, OptimiseReport& report) {
    const Connectivity& mesh = editor.mesh();
    const double mean = mean_energy(editor);
    std::deque<int> queue;
    std::vector<char> queued(mesh.num_vertices(), 0);
    const auto push = [&](int v) {
        if (v >= static_cast<int>(queued.size())) queued.resize(v + 1, 0);
        if (!queued[v] && irregular(mesh, v)) queued[v] = 1, queue.push_back(v);
    };
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (options.is_active(v)) push(v);
    const auto wake_around_last = [&] {
        for (const int v : editor.touched()) {
            if (!mesh.is_live_vertex(v)) continue;
            push(v);
            mesh.for_each_outgoing(v, [&](int h) {
                push(mesh.target(h));
                push(mesh.apex(h));
            });
        }
    };
    const auto most = static_cast<long>(kAttemptsPerVertex * mesh.num_vertices());
    std::vector<int> candidates;
    while (!queue.empty() && report.attempts < most) {
        const int v = queue.front();
        queue.pop_front();
        queued[v] = 0;
        if (!irregular(mesh, v)) continue;
        candidates.clear();
        mesh.for_each_outgoing(v, [&](int h) { candidates.push_back(h); });
        const int spokes = static_cast<int>(candidates.size());
        for (int i = 0; i < spokes; ++i) candidates.push_back(Connectivity::next(candidates[i]));
        for (int i = 0; i < static_cast<int>(candidates.size()); ++i) {
            const int h = candidates[i];
            bool kept = false;
            if (worth_a_flip(editor, h, kHopefulFlip, kHopefulPerGain)) {
                ++report.attempts;
                kept = editor.attempt(Operation::Flip, h, Aim::Mean, mean);
            }
            if (!kept && i < spokes && editor.length(h) < 1 && editor.collapse_gain(h) > 0 && editor.can_collapse(h)) {
                ++report.attempts;
                kept = editor.attempt(Operation::Collapse, h, Aim::Mean, mean);
            }
            if (kept) {
                ++report.kept;
                wake_around_last();
                break;
            }
        }
    }
}

// Tries operations on the edges of a bad triangle, then on those around its corners. @returns whether one was kept
template <class M>
bool improve_around(EditorOf<M>& editor, int t, double mean, OptimiseReport& report) {
    const Connectivity& mesh = editor.mesh();
    std::vector<int> candidates{3 * t, 3 * t + 1, 3 * t + 2};
    add_halfedges_around(mesh, mesh.triangle(t), candidates);
    const bool improved = any_halfedge(mesh, candidates, [&](int h, bool is_first) {
        const auto attempt = [&](Operation operation) {
            ++report.worst_attempts;
            return editor.attempt(operation, h, Aim::Worst, mean, Reach::Wide);
        };
        return (is_first && worth_a_flip(editor, h, kHopefulRise, 0) && attempt(Operation::Flip)) ||
               (editor.length(h) < 1 && editor.collapse_gain(h) >= 0 && editor.can_collapse(h) &&
                attempt(Operation::Collapse));
    });
    report.worst_kept += improved;
    return improved;
}

// Tries pairs of operations, the first on an edge of the triangle or, where its shape is very bad, of one around its
// corners.
template <class M>
bool improve_by_pairs(EditorOf<M>& editor, int t, double goal, double mean, OptimiseReport& report) {
    const Connectivity& mesh = editor.mesh();
    std::vector<int> edges{3 * t, 3 * t + 1, 3 * t + 2};
    const auto search = editor.quality(t) < goal - kVeryBad ? Search::Thorough : Search::Quick;
    if (search == Search::Thorough) add_halfedges_around(mesh, mesh.triangle(t), edges);
    const long last_move = editor.moves() + kMovesByPairs;
    const bool improved = any_halfedge(mesh, edges, [&](int h, bool is_first) {
        if (!is_first || editor.moves() > last_move) return false;
        const int g = mesh.twin(h);
        const auto attempt = [&](Operation operation, int halfedge) {
            ++report.worst_attempts;
            return editor.attempt_pair(operation, halfedge, mean, search);
        };
        return (editor.can_flip(h) && attempt(Operation::Flip, h)) ||
               (editor.can_collapse(h) && attempt(Operation::Collapse, h)) ||
               (g >= 0 && editor.can_collapse(g) && attempt(Operation::Collapse, g)) || attempt(Operation::Split, h);
    });
    report.worst_kept += improved;
    return improved;
}

// Tries to push its corners out of where they are stuck.
template <class M>
bool improve_by_pushes(EditorOf<M>& editor, int t, double mean, OptimiseReport& report) {
    const Connectivity& mesh = editor.mesh();
    std::vector<int> spokes;
    for (const int v : mesh.triangle(t))
        if (editor.vertex(v).bound == Bound::Free) mesh.for_each_outgoing(v, [&](int h) { spokes.push_back(h); });
    for (const int h : spokes) {
        ++report.worst_attempts;
        if (!editor.attempt(Operation::Push, h, Aim::Worst, mean, Reach::Wide)) continue;
        ++report.worst_kept;
        return true;
    }
    return false;
}

// Quality of a triangle, or less where a goal would be met but for edges at its corners that differ by much.
template <class M>
double standing(const EditorOf<M>& editor, int t, double goal) {
    double standing = editor.quality(t);
    for (const int v : editor.mesh().triangle(t))
        if (const double ratio = editor.fan_ratio(v); ratio > kWidestFan)
            standing = std::min(standing, goal * kWidestFan / ratio);
    return standing;
}

template <class M>
int count_below(const EditorOf<M>& editor, double goal) {
    int below = 0;
    for (int t = 0; t < editor.mesh().num_triangles(); ++t)
        if (editor.mesh().is_live_triangle(t) && !editor.is_frozen_triangle(t) && editor.quality(t) < goal) ++below;
    return below;
}

// The same for the triangles that do not stand a goal, judged by a high power of the energy, worst first. The goal
// rises to the one asked for, so that where many triangles are below it the bounded search goes to the worst of them.
// The active triangles whose standing is below a goal, the worst first.
template <class M, class IsActive, class Standing>
std::vector<std::pair<double, int>> triangles_below(const EditorOf<M>& editor, double goal, const IsActive& is_active,
                                                    const Standing& standing_of) {
    const Connectivity& mesh = editor.mesh();
    std::vector<std::pair<double, int>> below;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t) || !is_active(t) || editor.is_frozen_triangle(t)) continue;
        if (const double now = standing_of(t); now < goal) below.emplace_back(now, t);
    }
    std::sort(below.begin(), below.end());
    return below;
}

template <class M>
void attempt_for_worst(EditorOf<M>& editor, const OptimiseOptions& options, OptimiseReport& report) {
    const Connectivity& mesh = editor.mesh();
    const double mean = mean_energy(editor);
    long vertices = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) vertices += options.is_active(v);
    const auto bound = [&](long per_vertex) { return std::max(kMovesAtLeast, per_vertex * vertices); };
    const long last_move = editor.moves() + bound(kMovesPerVertex);
    long left_for_last_resorts = bound(kMovesByLastResortsPerVertex);
    const auto is_active = [&](int t) {
        const Triangle v = mesh.triangle(t);
        return options.is_active(v[0]) || options.is_active(v[1]) || options.is_active(v[2]);
    };
    // Triangles that nothing helped, with their standing and the goal then, and how far the search went: not, quickly
    // or thoroughly to last resorts.
    struct Tried {
        double standing, goal;
        int depth;
    };
    std::map<Triangle, Tried> hopeless;
    for (const double share : {0.75, 0.85, 0.95, 1.0}) {
        const double goal = share * options.goal;
        const auto standing_of = [&](int t) {
            return options.fans && share == 1 ? standing(editor, t, goal) : editor.quality(t);
        };
        const auto by_last_resorts = [&](int t) {
            if (left_for_last_resorts <= 0 || standing_of(t) >= goal - kFarBelow) return false;
            const long before = editor.moves();
            const bool improved =
                improve_by_pairs(editor, t, goal, mean, report) || improve_by_pushes(editor, t, mean, report);
            left_for_last_resorts -= editor.moves() - before;
            return improved;
        };
        for (int round = 0; round < kWorstRounds; ++round) {
            int kept_now = 0;
            for (const auto& [was, t] : triangles_below(editor, goal, is_active, standing_of)) {
                if (!mesh.is_live_triangle(t) || editor.moves() >= last_move) continue;
                const double now = standing_of(t);
                if (now >= goal) continue;
                const Triangle corners = mesh.triangle(t);
                const auto depth_at = [&](double at) { return (at < goal - kFarBelow) + (at < goal - kVeryBad); };
                const auto was_tried = [&](const Tried& tried) {
                    return (tried.goal == goal || tried.depth >= depth_at(now)) &&
                           std::abs(tried.standing - now) < kSameQuality;
                };
                if (const auto last = hopeless.find(corners); last != hopeless.end() && was_tried(last->second))
                    continue;
                const bool moved = editor.attempt(Operation::Move, 3 * t, Aim::Worst, mean, Reach::Wide);
                if ((moved && standing_of(t) >= goal) || improve_around(editor, t, mean, report) || by_last_resorts(t))
                    ++kept_now;
                else
                    hopeless[corners] = {standing_of(t), goal, depth_at(standing_of(t))};
            }
            if (kept_now == 0) break;
        }
    }
    report.below_goal = count_below(editor, options.goal);
}

// Rows of long facets, halved, leave a lattice that is stretched though all its edges are unit, and that no single
// operation improves. Where there is much of that its longest edges are split, and what follows makes a mesh without
// rows. @returns how many
template <class M>
int break_lattices(EditorOf<M>& editor) {
    const Connectivity& mesh = editor.mesh();
    const auto in_lattice = [&](int v) { return editor.vertex(v).bound == Bound::Free && mesh.valence(v) == 6; };
    std::vector<LengthAt> longest;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t) || editor.quality(t) >= kStretched) continue;
        const Triangle v = mesh.triangle(t);
        if (!std::all_of(v.begin(), v.end(), in_lattice)) continue;
        LengthAt edge{0, -1};
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (const double length = editor.length(h); length > edge.length) edge = {length, h};
        longest.push_back(edge);
    }
    if (static_cast<double>(longest.size()) < kMuchStretched * mesh.num_live_triangles()) return 0;
    std::sort(longest.begin(), longest.end(), [](const LengthAt& a, const LengthAt& b) {
        return std::pair(-a.length, a.halfedge) < std::pair(-b.length, b.halfedge);
    });
    int splits = 0;
    for (const LengthAt& e : longest)
        if (in_lattice(mesh.origin(e.halfedge)) && in_lattice(mesh.target(e.halfedge)) && editor.split(e.halfedge) >= 0)
            ++splits;
    return splits;
}

// Without a search the worst triangles still get better by moving their corners for their sake.
template <class M>
void relax_worst(EditorOf<M>& editor) {
    const Connectivity& mesh = editor.mesh();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t) || editor.quality(t) >= kPoor) continue;
        for (const int v : mesh.triangle(t)) editor.relax(v, Aim::Worst);
    }
}

}  // namespace

void take_report(const OptimiseReport& report, RemeshStatistics& statistics) {
    statistics.splits += report.splits;
    statistics.collapses += report.collapses;
    statistics.flips += report.flips;
    statistics.attempts += report.attempts + report.worst_attempts;
    statistics.kept += report.kept + report.worst_kept;
    statistics.below_goal = report.below_goal;
}

template <class M>
double check_estimate(const InterpolatedField<M>& control, const RemeshOptions& options) {
    const double predicted = control.predicted_triangles(), least = control.least_relative_size();
    if (predicted > options.max_triangles)
        throw std::length_error(fmt::format("the size map asks for about {:.15g} triangles, more than {:.0f}",
                                            std::round(predicted), options.max_triangles));
    if (least < kLeastSize)
        throw std::invalid_argument(fmt::format(
            "the size map goes down to {:.3g} of the coordinates, below {:g}: rounding leaves no triangles that small",
            least, kLeastSize));
    return predicted;
}

template <class M>
OptimiseReport optimise(EditorOf<M>& editor, const OptimiseOptions& options, StageClock& clock) {
    OptimiseReport report;
    // What comes from a draft, or is changed in places, needs less.
    const bool is_rough = !options.fast && !options.fitted && options.active.empty();
    const auto fit_lengths = [&] {
        split_long(editor, options, report);
        report.collapses += collapse_short(editor, options);
        divide_curves(editor, options, report);
    };
    const auto fit_shapes = [&](int times) {
        report.flips += flip_edges(editor, options);
        smooth(editor, options, times);
    };
    const auto is_far_from_fit = [&] {
        return !EdgesByLength(editor, options, Wanted::Long, kFarTooLong).list().empty();
    };
    const int rounds = is_rough ? kFitRounds : 1, most_rounds = is_rough ? kMostFitRounds : 1;
    // Triangles that are given are far from what is asked for. Needles become few before they are split; then again, as
    // collapses leave much to split.
    if (options.given) report.collapses += collapse_short(editor, options);
    for (int round = 0; round < rounds || (round < most_rounds && is_far_from_fit()); ++round) {
        fit_lengths();
        if (round == 0 && options.given) fit_lengths();
        // What is next to each other in space is next to each other in memory from here on.
        if (round == 0 && options.active.empty()) editor.renumber();
        fit_shapes(is_rough ? 2 : 1);
    }
    if (const int splits = options.fast || !options.active.empty() ? 0 : break_lattices(editor); splits > 0) {
        report.splits += splits;
        fit_shapes(2);
        fit_lengths();
        fit_shapes(2);
    }
    clock.done("fitting");
    if (options.fast) {
        relax_worst(editor);
    } else {
        fit_shapes(1);
        clock.done("smoothing");
        attempt_for_mean(editor, options, report);
        smooth(editor, options, 2);
        clock.done("attempts");
        attempt_for_worst(editor, options, report);
    }
    if (!options.fast || !options.active.empty()) editor.renumber();
    clock.done("worst");
    return report;
}

template <class M>
OptimiseReport polish(EditorOf<M>& editor, double goal, std::vector<char> active, StageClock& clock) {
    OptimiseReport report;
    attempt_for_worst(editor, {.goal = goal, .fans = true, .active = std::move(active)}, report);
    editor.renumber();
    clock.done("polishing");
    return report;
}

template double check_estimate(const InterpolatedField<Size>& control, const RemeshOptions& options);
template OptimiseReport optimise(EditorOf<Size>& editor, const OptimiseOptions& options, StageClock& clock);
template OptimiseReport polish(EditorOf<Size>& editor, double goal, std::vector<char> active, StageClock& clock);
template double check_estimate(const InterpolatedField<SizeTensor>& control, const RemeshOptions& options);
template OptimiseReport optimise(EditorOf<SizeTensor>& editor, const OptimiseOptions& options, StageClock& clock);
template OptimiseReport polish(EditorOf<SizeTensor>& editor, double goal, std::vector<char> active, StageClock& clock);

}  // namespace gradus
