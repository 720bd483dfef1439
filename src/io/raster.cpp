#include "raster.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace gradus::raster {
namespace {

constexpr int tile_size = 32;  // pixels; its samples stay in the second-level cache

/// Which triangles or lines touch which tile: those of tile i are items[start[i]] up to items[start[i + 1]], in drawing
/// order.
struct Bins {
    std::vector<std::size_t> start;
    std::vector<int> items;
    std::span<const int> of(std::size_t tile) const {
        return {items.data() + start[tile], start[tile + 1] - start[tile]};
    }
};

/// Tiles from (x0, y0) up to and including (x1, y1); empty if x1 < x0.
struct TileBox {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
};

struct Grid {
    int columns, rows;
    explicit Grid(const Scene& scene)
        : columns((scene.width + tile_size - 1) / tile_size), rows((scene.height + tile_size - 1) / tile_size) {}

    TileBox covered(double left, double top, double right, double bottom) const {
        const double w = columns * tile_size, h = rows * tile_size;
        // Negated, so that coordinates that are not numbers are left out too.
        if (!(right >= 0 && bottom >= 0 && left < w && top < h)) return {};
        const auto tile = [](double x, int count) {
            return static_cast<int>(std::clamp(x / tile_size, 0.0, count - 1.0));
        };
        return {tile(left, columns), tile(top, rows), tile(right, columns), tile(bottom, rows)};
    }
};

template <class Box>
Bins sort_into_tiles(const Grid& grid, std::size_t count, const Box& box_of) {
    Bins bins;
    bins.start.assign(static_cast<std::size_t>(grid.columns) * grid.rows + 1, 0);
    std::vector<TileBox> boxes(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { boxes[i] = box_of(i); });
    const auto for_each_tile = [&](const auto& visit) {
        for (std::size_t i = 0; i < count; ++i)
            for (int y = boxes[i].y0; y <= boxes[i].y1; ++y)
                for (int x = boxes[i].x0; x <= boxes[i].x1; ++x)
                    visit(static_cast<std::size_t>(y) * grid.columns + x, static_cast<int>(i));
    };
    for_each_tile([&](std::size_t tile, int) { ++bins.start[tile + 1]; });
    for (std::size_t t = 1; t < bins.start.size(); ++t) bins.start[t] += bins.start[t - 1];
    bins.items.resize(bins.start.back());
    std::vector<std::size_t> next(bins.start.begin(), bins.start.end() - 1);
    for_each_tile([&](std::size_t tile, int item) { bins.items[next[tile]++] = item; });
    return bins;
}

/// Samples of one tile, row by row.
struct Tile {
    int x0 = 0, y0 = 0;         ///< its first pixel
    int columns = 0, rows = 0;  ///< samples
    std::vector<double> depth;
    std::vector<Colour> colour;

    struct Item {
        double depth;  ///< of its nearest corner
        int triangle;
    };
    std::vector<Item> order;
};

double nearest(const Scene& scene, int t) {
    const auto& [a, b, c] = scene.triangles[t];
    return std::max({scene.points[a].depth, scene.points[b].depth, scene.points[c].depth});
}

/// Signed distance in pixels to the line through an edge: a x + b y + c, positive inside the triangle.
struct EdgeDistance {
    double a = 0, b = 0, c = 0;
};

/// Both triangles of an edge take it from its lower vertex to its higher one, so their distances differ in sign only:
/// no sample between them can be missed.
EdgeDistance edge_distance(const ScreenPoint& p, const ScreenPoint& q, bool flipped, const Tile& tile) {
    const ScreenPoint& low = flipped ? q : p;
    const ScreenPoint& high = flipped ? p : q;
    const double dx = high.x - low.x, dy = high.y - low.y, length = std::sqrt(dx * dx + dy * dy);
    const double s = (flipped ? -1 : 1) / length;
    EdgeDistance e{-dy * s, dx * s, 0};
    e.c = -(e.a * (low.x - tile.x0) + e.b * (low.y - tile.y0));
    return e;
}

/// How the edges of a triangle are drawn: width in pixels and opacity.
struct EdgeStyle {
    double half_width = 0, opacity = 0;
};

/// Thins and then fades the edges of triangles only a few pixels wide, so that the tone of dense parts stays even.
EdgeStyle adapt_edges(double width, double inradius) {
    constexpr double most = 0.38, thinnest = 0.6;  // covered fraction of a triangle; fraction of the width asked for
    if (!(width > 0)) return {};
    // A border of width b inside a triangle covers 1 - (1 - b/r)^2 of it.
    const double wanted = 2 * inradius * (1 - std::sqrt(1 - most));
    const double drawn = std::clamp(wanted, thinnest * width, width);
    const double rest = std::max(0.0, 1 - drawn / (2 * inradius));
    const double covered = 1 - rest * rest;
    return {drawn / 2, std::min(1.0, most / covered)};
}

/// First and last sample, of `count`, whose centre is in [low, high] pixels of the tile.
struct SampleSpan {
    int first, last;
};
SampleSpan samples_in(double low, double high, int samples, int count) {
    const double first = std::ceil(low * samples - 0.5), last = std::floor(high * samples - 0.5);
    return {static_cast<int>(std::clamp(first, 0.0, static_cast<double>(count))),
            static_cast<int>(std::clamp(last, -1.0, count - 1.0))};
}

/// Part of a row that can be inside a triangle, a sample too wide at both ends: whether a sample is inside is decided
/// by its distances.
SampleSpan between_edges(const std::array<EdgeDistance, 3>& edge, const std::array<double, 3>& base, SampleSpan row,
                         int samples) {
    for (int k = 0; k < 3; ++k) {
        constexpr double flat = 1e-6;  // so slanted an edge bounds no part of a row worth the division
        if (std::abs(edge[k].a) < flat) continue;
        const double x = std::clamp(-base[k] / edge[k].a * samples - 0.5, -2.0, row.last + 2.0);
        if (edge[k].a > 0)
            row.first = std::max(row.first, static_cast<int>(x) - 1);
        else
            row.last = std::min(row.last, static_cast<int>(x) + 1);
    }
    return row;
}

/// A triangle ready to be filled. Its corners run clockwise as seen; edge k is opposite corner k.
struct Setup {
    std::array<EdgeDistance, 3> edge;
    /// Values at the corners over their heights: their sums with the distances interpolate. Light and place are
    /// weighted.
    std::array<double, 3> depth, weight, light, place;
    std::array<double, 3> hidden{0, 0, 0};  ///< added to the distance from an edge that is not drawn: infinite
    EdgeStyle style;
    Colour fill, shadow;
    SampleSpan rows, columns;  ///< its box
};

double weighted(const std::array<double, 3>& d, const std::array<double, 3>& values) {
    return d[0] * values[0] + d[1] * values[1] + d[2] * values[2];
}

/// Nothing if the triangle is seen as a line.
std::optional<Setup> set_up(const Scene& scene, std::size_t t, const Tile& tile) {
    Triangle v = scene.triangles[t];
    std::array<int, 3> order{0, 1, 2};
    const double area = screen_area(scene.points[v[0]], scene.points[v[1]], scene.points[v[2]]);
    if (area == 0) return {};
    const bool back = area > 0;
    if (!back) std::swap(v[1], v[2]), std::swap(order[1], order[2]);
    const std::array<const ScreenPoint*, 3> p{&scene.points[v[0]], &scene.points[v[1]], &scene.points[v[2]]};

    Setup setup;
    const auto [left, right] = std::minmax({p[0]->x, p[1]->x, p[2]->x});
    const auto [top, bottom] = std::minmax({p[0]->y, p[1]->y, p[2]->y});
    setup.rows = samples_in(top - tile.y0, bottom - tile.y0, scene.samples, tile.rows);
    setup.columns = samples_in(left - tile.x0, right - tile.x0, scene.samples, tile.columns);
    double perimeter = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double dx = p[j]->x - p[i]->x, dy = p[j]->y - p[i]->y, length = std::sqrt(dx * dx + dy * dy);
        if (length == 0) return {};
        perimeter += length;
        const double over_height = length / std::abs(area);
        setup.edge[k] = edge_distance(*p[i], *p[j], v[i] > v[j], tile);
        setup.depth[k] = p[k]->depth * over_height;
        setup.weight[k] = p[k]->weight * over_height;
        setup.light[k] = scene.corners[t].light[order[k]] * setup.weight[k];
        setup.place[k] = scene.corners[t].place[order[k]] * setup.weight[k];
        if (!scene.shown_edges.empty()) {
            const int bit = (order[i] + 1) % 3 == order[j] ? order[i] : order[j];
            if (!(scene.shown_edges[t] >> bit & 1)) setup.hidden[k] = std::numeric_limits<double>::infinity();
        }
    }
    setup.style = adapt_edges(scene.edge_width, std::abs(area) / perimeter);
    setup.fill = scene.fill[back], setup.shadow = scene.shadow[back];
    return setup;
}

/// Colour of a sample at these distances from the edges.
Colour colour_of(const Scene& scene, const Setup& setup, const std::array<double, 3>& d) {
    const double scale = 1 / weighted(d, setup.weight);
    const float light = static_cast<float>(weighted(d, setup.light) * scale);
    Colour colour;
    if (scene.map) {
        // Shaded less than a plain surface, since darkness would be taken for a value.
        constexpr float deepest = 0.3f;
        colour = colour_at(*scene.map, weighted(d, setup.place) * scale);
        colour = mix(mix(colour, {0, 0, 0}, deepest), colour, light);
    } else {
        colour = mix(setup.shadow, setup.fill, light);
    }
    if (setup.style.opacity == 0) return colour;
    const double nearest_edge = std::min({d[0] + setup.hidden[0], d[1] + setup.hidden[1], d[2] + setup.hidden[2]});
    const double cover = std::clamp((setup.style.half_width - nearest_edge) * scene.samples + 0.5, 0.0, 1.0);
    return cover > 0 ? mix(colour, scene.edge, static_cast<float>(cover * setup.style.opacity)) : colour;
}

void draw_triangle(const Scene& scene, std::size_t t, Tile& tile) {
    const std::optional<Setup> found = set_up(scene, t, tile);
    if (!found) return;
    const Setup& setup = *found;
    const auto& edge = setup.edge;
    const double step = 1.0 / scene.samples;
    constexpr int wide = 8;  // samples of a row worth a look for the part between the edges
    for (int row = setup.rows.first; row <= setup.rows.last; ++row) {
        const double y = (row + 0.5) * step;
        const std::array<double, 3> base{edge[0].b * y + edge[0].c, edge[1].b * y + edge[1].c,
                                         edge[2].b * y + edge[2].c};
        const bool narrow = setup.columns.last - setup.columns.first < wide;
        const SampleSpan columns = narrow ? setup.columns : between_edges(edge, base, setup.columns, scene.samples);
        for (int column = columns.first; column <= columns.last; ++column) {
            const double x = (column + 0.5) * step;
            const std::array<double, 3> d{edge[0].a * x + base[0], edge[1].a * x + base[1], edge[2].a * x + base[2]};
            if (d[0] < 0 || d[1] < 0 || d[2] < 0) continue;
            const std::size_t sample = static_cast<std::size_t>(row) * tile.columns + column;
            const double depth = weighted(d, setup.depth);
            if (depth <= tile.depth[sample]) continue;
            tile.depth[sample] = depth;
            tile.colour[sample] = colour_of(scene, setup, d);
        }
    }
}

void draw_line(const Scene& scene, const Line& line, Tile& tile) {
    const Eigen::Vector2d origin(tile.x0, tile.y0), a = line.from - origin, b = line.to - origin, along = b - a;
    const double squared = along.squaredNorm(), reach = line.width / 2 + 1;
    const SampleSpan rows =
        samples_in(std::min(a.y(), b.y()) - reach, std::max(a.y(), b.y()) + reach, scene.samples, tile.rows);
    const SampleSpan columns =
        samples_in(std::min(a.x(), b.x()) - reach, std::max(a.x(), b.x()) + reach, scene.samples, tile.columns);
    for (int row = rows.first; row <= rows.last; ++row) {
        for (int column = columns.first; column <= columns.last; ++column) {
            const Eigen::Vector2d p((column + 0.5) / scene.samples, (row + 0.5) / scene.samples);
            const double t = squared > 0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
            const double distance = (p - a - t * along).norm();
            const double cover = std::clamp((line.width / 2 - distance) * scene.samples + 0.5, 0.0, 1.0);
            if (cover == 0) continue;
            const std::size_t sample = static_cast<std::size_t>(row) * tile.columns + column;
            if (line.from_depth + t * (line.to_depth - line.from_depth) < tile.depth[sample]) continue;
            tile.colour[sample] = mix(tile.colour[sample], line.colour, static_cast<float>(cover));
        }
    }
}

void average_into(const Scene& scene, const Tile& tile, Image& image) {
    const int s = scene.samples;
    const float share = 1.0f / static_cast<float>(s * s);
    for (int y = 0; y < tile.rows / s; ++y) {
        for (int x = 0; x < tile.columns / s; ++x) {
            Colour sum;
            for (int row = y * s; row < (y + 1) * s; ++row) {
                const Colour* sample = tile.colour.data() + static_cast<std::size_t>(row) * tile.columns + x * s;
                for (int i = 0; i < s; ++i) sum.r += sample[i].r, sum.g += sample[i].g, sum.b += sample[i].b;
            }
            image.set(tile.x0 + x, tile.y0 + y, {sum.r * share, sum.g * share, sum.b * share});
        }
    }
}

}  // namespace

double screen_area(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

Image draw(const Scene& scene) {
    const Grid grid(scene);
    const Bins triangles = sort_into_tiles(grid, scene.triangles.size(), [&](std::size_t t) {
        const Triangle& v = scene.triangles[t];
        const ScreenPoint &a = scene.points[v[0]], &b = scene.points[v[1]], &c = scene.points[v[2]];
        return grid.covered(std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::max({a.x, b.x, c.x}),
                            std::max({a.y, b.y, c.y}));
    });
    const Bins lines = sort_into_tiles(grid, scene.lines.size(), [&](std::size_t i) {
        const Line& line = scene.lines[i];
        const Eigen::Array2d reach = Eigen::Array2d::Constant(line.width / 2 + 1);
        const Eigen::Array2d low = line.from.cwiseMin(line.to).array() - reach,
                             high = line.from.cwiseMax(line.to).array() + reach;
        return grid.covered(low.x(), low.y(), high.x(), high.y());
    });

    Image image(scene.width, scene.height, scene.background);
    tbb::enumerable_thread_specific<Tile> tiles;
    tbb::parallel_for(0, grid.columns * grid.rows, [&](int i) {
        if (triangles.of(i).empty() && lines.of(i).empty()) return;
        Tile& tile = tiles.local();
        tile.x0 = i % grid.columns * tile_size, tile.y0 = i / grid.columns * tile_size;
        tile.columns = std::min(tile_size, scene.width - tile.x0) * scene.samples;
        tile.rows = std::min(tile_size, scene.height - tile.y0) * scene.samples;
        const std::size_t count = static_cast<std::size_t>(tile.columns) * tile.rows;
        tile.depth.assign(count, -std::numeric_limits<double>::infinity());
        tile.colour.assign(count, scene.background);
        // Near triangles first: what they hide is then not shaded.
        tile.order.clear();
        for (const int t : triangles.of(i)) tile.order.push_back({nearest(scene, t), t});
        std::ranges::sort(tile.order, [](const Tile::Item& a, const Tile::Item& b) {
            return std::tie(b.depth, a.triangle) < std::tie(a.depth, b.triangle);
        });
        for (const Tile::Item& item : tile.order) draw_triangle(scene, item.triangle, tile);
        for (const int l : lines.of(i)) draw_line(scene, scene.lines[l], tile);
        average_into(scene, tile, image);
    });
    return image;
}

}  // namespace gradus::raster
