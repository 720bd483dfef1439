#include "gradus/mesh/connectivity.hpp"

#include "../assert.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

// Half-edges by the larger of their two vertices, as a counting sort: twins are found within short lists.
std::vector<int> match_twins(int num_vertices, std::span<const Triangle> triangles) {
    const int num_halfedges = static_cast<int>(3 * triangles.size());
    const auto name = [](int a, int b) { return std::to_string(a) + "-" + std::to_string(b); };
    const auto ends = [&](int h) {
        const Triangle& t = triangles[h / 3];
        return std::pair{t[h % 3], t[(h % 3 + 1) % 3]};
    };
    std::vector<int> first(num_vertices + 1, 0), order(num_halfedges), twin(num_halfedges, Connectivity::kNone);
    for (int h = 0; h < num_halfedges; ++h) ++first[std::max(ends(h).first, ends(h).second) + 1];
    for (int v = 0; v < num_vertices; ++v) first[v + 1] += first[v];
    std::vector<int> fill(first.begin(), first.end() - 1);
    for (int h = 0; h < num_halfedges; ++h) order[fill[std::max(ends(h).first, ends(h).second)]++] = h;
    for (int v = 0; v < num_vertices; ++v)
        for (int i = first[v]; i < first[v + 1]; ++i)
            for (int j = i + 1; j < first[v + 1]; ++j) {
                const auto [a, b] = ends(order[i]);
                const auto [c, d] = ends(order[j]);
                if (a == c && b == d)
                    throw std::invalid_argument("Connectivity: edge " + name(a, b) +
                                                " is wrongly oriented or has too many triangles");
                if (a != d || b != c) continue;
                if (twin[order[i]] != Connectivity::kNone || twin[order[j]] != Connectivity::kNone)
                    throw std::invalid_argument("Connectivity: edge " + name(a, b) + " has more than two triangles");
                twin[order[i]] = order[j];
                twin[order[j]] = order[i];
            }
    return twin;
}

}  // namespace

Connectivity::Connectivity(int num_vertices, std::span<const Triangle> triangles) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles[t];
        const bool valid = std::min({a, b, c}) >= 0 && std::max({a, b, c}) < num_vertices && a != b && b != c && c != a;
        if (!valid)
            throw std::invalid_argument("Connectivity: triangle " + std::to_string(t) +
                                        " has a bad or repeated vertex index");
    }
    twin_ = match_twins(num_vertices, triangles);
    origin_.reserve(3 * triangles.size());
    for (const Triangle& t : triangles) origin_.insert(origin_.end(), t.begin(), t.end());
    tag_.assign(origin_.size(), kNone);
    outgoing_.assign(num_vertices, kNone);
    valence_.assign(num_vertices, 0);
    std::vector<int> fans(num_vertices, 0);
    for (int h = 0; h < static_cast<int>(origin_.size()); ++h) {
        ++fans[origin_[h]];
        if (outgoing_[origin_[h]] == kNone || twin_[h] == kNone) outgoing_[origin_[h]] = h;
    }
    for (int v = 0; v < num_vertices; ++v) {
        if (outgoing_[v] == kNone) continue;
        int walked = 0;
        for_each_outgoing(v, [&](int) { ++walked; });
        if (walked != fans[v])
            throw std::invalid_argument("Connectivity: the triangles of vertex " + std::to_string(v) +
                                        " form more than one fan");
        valence_[v] = walked + (is_boundary_vertex(v) ? 1 : 0);
    }
}

Connectivity::Numbering Connectivity::breadth_first() const {
    Numbering numbering;
    std::vector<int>&order = numbering.vertices, &triangles = numbering.triangles, &number = numbering.new_number;
    number.assign(num_vertices(), kNone);
    order.reserve(num_vertices());
    for (int start = 0; start < num_vertices(); ++start) {
        if (!is_live_vertex(start) || number[start] != kNone) continue;
        number[start] = static_cast<int>(order.size());
        order.push_back(start);
        for (std::size_t i = number[start]; i < order.size(); ++i)
            for_each_outgoing(order[i], [&](int h) {
                for (const int v : {target(h), apex(h)})
                    if (number[v] == kNone) {
                        number[v] = static_cast<int>(order.size());
                        order.push_back(v);
                    }
            });
    }
    // A counting sort.
    const auto first_of = [&](int t) {
        const Triangle v = triangle(t);
        return std::min({number[v[0]], number[v[1]], number[v[2]]});
    };
    std::vector<int> start(order.size() + 1, 0);
    triangles.resize(num_live_triangles());
    for (int t = 0; t < num_triangles(); ++t)
        if (is_live_triangle(t)) ++start[first_of(t) + 1];
    for (std::size_t v = 0; v < order.size(); ++v) start[v + 1] += start[v];
    for (int t = 0; t < num_triangles(); ++t)
        if (is_live_triangle(t)) triangles[start[first_of(t)]++] = t;
    return numbering;
}

Connectivity Connectivity::renumbered(const Numbering& numbering) const {
    const auto& [order, triangles, number] = numbering;
    std::vector<int> place(num_triangles(), kNone);
    for (std::size_t i = 0; i < triangles.size(); ++i) place[triangles[i]] = static_cast<int>(i);
    const auto moved = [&](int h) { return h == kNone ? kNone : 3 * place[h / 3] + h % 3; };
    Connectivity result;
    result.origin_.reserve(3 * triangles.size());
    result.twin_.reserve(3 * triangles.size());
    result.tag_.reserve(3 * triangles.size());
    for (const int t : triangles)
        for (int h = 3 * t; h < 3 * t + 3; ++h) {
            result.origin_.push_back(number[origin_[h]]);
            result.twin_.push_back(moved(twin_[h]));
            result.tag_.push_back(tag_[h]);
        }
    result.outgoing_.reserve(order.size());
    result.valence_.reserve(order.size());
    for (const int v : order) {
        result.outgoing_.push_back(moved(outgoing_[v]));
        result.valence_.push_back(valence_[v]);
    }
    return result;
}

int Connectivity::find_edge(int a, int b) const {
    if (!is_live_vertex(a)) return kNone;
    int found = kNone;
    for_each_outgoing(a, [&](int h) {
        if (target(h) == b)
            found = h;
        else if (apex(h) == b && twin_[prev(h)] == kNone)
            found = prev(h);
    });
    return found;
}

void Connectivity::Journal::clear() {
    triangles.clear();
    vertices.clear();
    recycled_triangles.clear();
    recycled_vertices.clear();
}

void Connectivity::touch(int t) {
    if (!journal_) return;
    const int h = 3 * t;
    journal_->triangles.push_back({t,
                                   {origin_[h], origin_[h + 1], origin_[h + 2]},
                                   {twin_[h], twin_[h + 1], twin_[h + 2]},
                                   {tag_[h], tag_[h + 1], tag_[h + 2]}});
}

void Connectivity::touch_vertex(int v) {
    if (journal_) journal_->vertices.push_back({v, outgoing_[v], valence_[v]});
}

void Connectivity::undo(Journal& journal) {
    journal_ = nullptr;
    for (auto i = journal.triangles.rbegin(); i != journal.triangles.rend(); ++i)
        for (int k = 0; k < 3; ++k) {
            origin_[3 * i->triangle + k] = i->origin[k];
            twin_[3 * i->triangle + k] = i->twin[k];
            tag_[3 * i->triangle + k] = i->tag[k];
        }
    for (auto i = journal.vertices.rbegin(); i != journal.vertices.rend(); ++i) {
        outgoing_[i->vertex] = i->outgoing;
        valence_[i->vertex] = i->valence;
    }
    const auto take_back = [](std::vector<int>& free, const std::vector<Journal::Recycling>& recycled) {
        for (auto i = recycled.rbegin(); i != recycled.rend(); ++i) {
            if (!i->freed) {
                free.push_back(i->number);
                continue;
            }
            GRADUS_ASSERT(!free.empty() && free.back() == i->number);
            free.pop_back();
        }
    };
    take_back(free_triangles_, journal.recycled_triangles);
    take_back(free_vertices_, journal.recycled_vertices);
    journal.clear();
}

// The boundary half-edge is found by turning clockwise from any outgoing one.
void Connectivity::set_outgoing(int v, int h) {
    GRADUS_ASSERT(h != kNone && origin_[h] == v);
    const int first = h;
    while (twin_[h] != kNone) {
        h = next(twin_[h]);
        if (h == first) break;
    }
    outgoing_[v] = h;
}

int Connectivity::new_triangle() {
    int t = num_triangles();
    if (!free_triangles_.empty()) {
        t = free_triangles_.back();
        free_triangles_.pop_back();
    } else {
        origin_.resize(origin_.size() + 3, kNone);
        twin_.resize(twin_.size() + 3, kNone);
        tag_.resize(tag_.size() + 3, kNone);
    }
    GRADUS_ASSERT(!is_live_triangle(t));
    touch(t);
    if (journal_) journal_->recycled_triangles.push_back({t, false});
    return t;
}

int Connectivity::new_vertex() {
    int v = num_vertices();
    if (!free_vertices_.empty()) {
        v = free_vertices_.back();
        free_vertices_.pop_back();
    } else {
        outgoing_.push_back(kNone);
        valence_.push_back(0);
    }
    GRADUS_ASSERT(!is_live_vertex(v));
    touch_vertex(v);
    if (journal_) journal_->recycled_vertices.push_back({v, false});
    return v;
}

void Connectivity::flip(int h0) {
    GRADUS_ASSERT(h0 >= 0 && is_live_triangle(h0 / 3) && twin_[h0] != kNone);
    GRADUS_ASSERT(find_edge(apex(h0), apex(twin_[h0])) == kNone);
    // Triangles v w c and w v d become v d c and w c d.
    const int h1 = next(h0), h2 = prev(h0), g0 = twin_[h0], g1 = next(g0), g2 = prev(g0);
    const int v = origin_[h0], w = origin_[g0], c = origin_[h2], d = origin_[g2];
    const int right = twin_[g1], left = twin_[h1], right_tag = tag_[g1], left_tag = tag_[h1];
    touch(h0 / 3);
    touch(g0 / 3);
    if (right != kNone) touch(right / 3);
    if (left != kNone) touch(left / 3);
    for (const int x : {v, w, c, d}) touch_vertex(x);
    origin_[h1] = d;
    origin_[g1] = c;
    link(h0, right);
    link(g0, left);
    link(h1, g1);
    tag_[h0] = right_tag;
    tag_[g0] = left_tag;
    tag_[h1] = tag_[g1] = kNone;
    --valence_[v];
    --valence_[w];
    ++valence_[c];
    ++valence_[d];
    set_outgoing(v, h0);
    set_outgoing(w, g0);
    set_outgoing(c, h2);
    set_outgoing(d, g2);
}

int Connectivity::split(int h) {
    GRADUS_ASSERT(h >= 0 && is_live_triangle(h / 3));
    const int m = new_vertex(), g = twin_[h], edge_tag = tag_[h];
    const int v = origin_[h], w = target(h);
    // Cuts the triangle of `side` (from a to b, opposite c) into a m c (in place) and m b c (new).
    const auto cut = [&](int side, int b) {
        const int t = side / 3, along = next(side), outer = twin_[along], outer_tag = tag_[along], c = apex(side);
        const int fresh = new_triangle();
        touch(t);
        if (outer != kNone) touch(outer / 3);
        touch_vertex(c);
        touch_vertex(b);
        const int n0 = 3 * fresh;
        origin_[n0] = m;
        origin_[n0 + 1] = b;
        origin_[n0 + 2] = c;
        tag_[n0] = edge_tag;
        tag_[n0 + 1] = outer_tag;
        tag_[n0 + 2] = kNone;
        link(n0 + 1, outer);
        origin_[along] = m;
        tag_[along] = kNone;
        link(n0 + 2, along);
        ++valence_[c];
        return n0;  // m -> b
    };
    const int beyond = cut(h, w);
    valence_[m] = g == kNone ? 3 : 4;
    if (g == kNone) {
        twin_[beyond] = kNone;
    } else {
        const int behind = cut(g, v);  // m -> v
        link(h, behind);
        link(beyond, g);
    }
    set_outgoing(m, beyond);
    set_outgoing(w, next(beyond));
    set_outgoing(v, h);
    set_outgoing(apex(h), prev(h));
    if (g != kNone) {
        set_outgoing(apex(g), prev(g));
    }
    return m;
}

bool Connectivity::can_collapse(int h) const {
    const int v = origin(h), w = target(h), g = twin_[h];
    const int c = apex(h), d = g == kNone ? kNone : apex(g);
    if (g != kNone && is_boundary_vertex(v) && is_boundary_vertex(w)) return false;
    for (const int x : {c, d})
        if (x != kNone && valence_[x] <= (is_boundary_vertex(x) ? 2 : 3)) return false;
    if (g == kNone && twin_[next(h)] == kNone && twin_[prev(h)] == kNone) return false;  // a lone triangle
    // A triangle both of whose other edges are on the boundary would leave a dangling edge.
    if (twin_[next(h)] == kNone && twin_[prev(h)] == kNone) return false;
    if (g != kNone && twin_[next(g)] == kNone && twin_[prev(g)] == kNone) return false;
    // Link condition: v and w have no common neighbour but c and d.
    bool simple = true;
    const auto check = [&](int x) {
        if (x != c && x != d && x != w && find_edge(w, x) != kNone) simple = false;
    };
    for_each_outgoing(v, [&](int e) {
        check(target(e));
        check(apex(e));
    });
    return simple;
}

void Connectivity::collapse(int h) {
    GRADUS_ASSERT(h >= 0 && is_live_triangle(h / 3) && can_collapse(h));
    const int v = origin(h), w = target(h), g = twin_[h];
    const int c = apex(h), d = g == kNone ? kNone : apex(g);
    for_each_outgoing(v, [&](int e) { touch(e / 3); });
    for (const int x : {v, w, c, d})
        if (x != kNone) touch_vertex(x);
    int lost = 1;  // edges of v that do not reach w, less those that coincide with edges of w
    int some_of_w = kNone;
    std::array<int, 24> fixed;
    std::vector<int> many;
    int count = 0;
    for_each_outgoing(v, [&](int e) {
        if (count < 24)
            fixed[count] = e;
        else
            many.push_back(e);
        ++count;
    });
    for (int i = 0; i < count; ++i) origin_[i < 24 ? fixed[i] : many[i - 24]] = w;
    const auto close = [&](int side, int x) {
        // The triangle of `side` vanishes; its two other edges become one.
        const int a = next(side), b = prev(side), outer_a = twin_[a], outer_b = twin_[b];
        const int tag = tag_[a] != kNone ? tag_[a] : tag_[b];
        if (outer_a != kNone) touch(outer_a / 3);
        if (outer_b != kNone) touch(outer_b / 3);
        link(outer_a, outer_b);
        if (outer_a == kNone && outer_b != kNone) twin_[outer_b] = kNone;
        if (outer_b == kNone && outer_a != kNone) twin_[outer_a] = kNone;
        if (outer_a != kNone) tag_[outer_a] = tag;
        if (outer_b != kNone) tag_[outer_b] = tag;
        --valence_[x];
        ++lost;
        return std::pair{outer_a, outer_b};
    };
    const auto remove = [&](int t) {
        for (int k = 0; k < 3; ++k) origin_[3 * t + k] = twin_[3 * t + k] = tag_[3 * t + k] = kNone;
        free_triangles_.push_back(t);
        if (journal_) journal_->recycled_triangles.push_back({t, true});
    };
    // On the h side: next(h) is w -> c and prev(h) is c -> v; on the g side next(g) is v -> d and prev(g) is d -> w.
    const auto [outer_wc, outer_cv] = close(h, c);
    // outer_wc runs c -> w, outer_cv runs v(=w) -> c
    if (outer_cv != kNone)
        some_of_w = outer_cv;
    else if (outer_wc != kNone)
        some_of_w = next(outer_wc);
    const int some_of_c = outer_wc != kNone ? outer_wc : outer_cv != kNone ? next(outer_cv) : kNone;
    int some_of_d = kNone;
    if (g != kNone) {
        const auto [outer_vd, outer_dw] = close(g, d);  // d -> v(=w), w -> d
        if (outer_dw != kNone)
            some_of_w = outer_dw;
        else if (outer_vd != kNone && some_of_w == kNone)
            some_of_w = next(outer_vd);
        some_of_d = outer_vd != kNone ? outer_vd : outer_dw != kNone ? next(outer_dw) : kNone;
    }
    valence_[w] += valence_[v] - 1 - lost;
    remove(h / 3);
    if (g != kNone) remove(g / 3);
    outgoing_[v] = kNone;
    valence_[v] = 0;
    free_vertices_.push_back(v);
    if (journal_) journal_->recycled_vertices.push_back({v, true});
    set_outgoing(w, some_of_w);
    set_outgoing(c, some_of_c);
    if (d != kNone) set_outgoing(d, some_of_d);
}

namespace {

// @returns a fault of a list of numbers that are free, or an empty string
template <class IsLive>
std::string check_free(const std::string& kind, const std::vector<int>& free, int count, const IsLive& is_live) {
    std::vector<char> listed(count, 0);
    for (const int i : free) {
        if (i < 0 || i >= count) return "free " + kind + " " + std::to_string(i) + " is out of range";
        if (is_live(i)) return "free " + kind + " " + std::to_string(i) + " is alive";
        if (listed[i]) return "free " + kind + " " + std::to_string(i) + " is listed twice";
        listed[i] = 1;
    }
    return {};
}

}  // namespace

// Before anything is followed, where it leads is checked.
std::string Connectivity::check() const {
    const int halfedges = 3 * num_triangles(), vertices = num_vertices();
    const std::size_t size = origin_.size();
    if (size % 3 != 0 || twin_.size() != size || tag_.size() != size || valence_.size() != outgoing_.size())
        return "arrays differ in length";
    const auto at = [](const char* fault, int h) { return fault + (" at half-edge " + std::to_string(h)); };
    const auto of = [](const char* fault, int v) { return fault + (" of vertex " + std::to_string(v)); };
    const auto is_halfedge = [&](int h) { return h >= 0 && h < halfedges && origin_[h] != kNone; };
    for (int h = 0; h < halfedges; ++h) {
        if ((origin_[h] == kNone) != (target(h) == kNone)) return at("half a triangle", h);
        if (origin_[h] == kNone) {
            if (twin_[h] != kNone || tag_[h] != kNone) return at("remains of a triangle", h);
            continue;
        }
        if (origin_[h] < 0 || origin_[h] >= vertices || !is_live_vertex(origin_[h])) return at("dead vertex", h);
        if (origin_[h] == target(h)) return at("twice the same vertex", h);
        if (twin_[h] != kNone && !is_halfedge(twin_[h])) return at("dead twin", h);
    }
    std::vector<int> fans(vertices, 0);
    for (int h = 0; h < halfedges; ++h) {
        if (origin_[h] == kNone) continue;
        ++fans[origin_[h]];
        const int g = twin_[h];
        if (g == kNone) continue;
        if (twin_[g] != h) return at("twins disagree", h);
        if (origin_[g] != target(h) || target(g) != origin_[h]) return at("twins have other ends", h);
        if (tag_[g] != tag_[h]) return at("tags differ", h);
    }
    std::vector<int> joined_to(vertices, kNone);
    for (int v = 0; v < vertices; ++v) {
        if (!is_live_vertex(v)) {
            if (valence_[v] != 0) return of("valence", v);
            continue;
        }
        if (!is_halfedge(outgoing_[v]) || origin_[outgoing_[v]] != v) return of("outgoing half-edge", v);
        // As twins agree, this ends.
        int walked = 0;
        for_each_outgoing(v, [&](int) { ++walked; });
        if (walked != fans[v]) return of("fan", v);
        if (valence_[v] != walked + (is_boundary_vertex(v) ? 1 : 0)) return of("valence", v);
        bool twice = false;
        for_each_edge(v, [&](int, int other) {
            twice = twice || joined_to[other] == v;
            joined_to[other] = v;
        });
        if (twice) return of("two edges to the same neighbour", v);
    }
    const std::string fault =
        check_free("triangle", free_triangles_, num_triangles(), [&](int t) { return is_live_triangle(t); });
    if (!fault.empty()) return fault;
    if (std::count(origin_.begin(), origin_.end(), kNone) != 3 * static_cast<long>(free_triangles_.size()))
        return "a triangle is removed and not free";
    return check_free("vertex", free_vertices_, vertices, [&](int v) { return is_live_vertex(v); });
}

}  // namespace gradus
