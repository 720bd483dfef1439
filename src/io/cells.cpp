#include "cells.hpp"

namespace gradus::io {

void SurfaceCells::add_triangle(TriangleSoup& soup, int a, int b, int c) {
    soup.triangles.push_back({a, b, c});
    cell_of_triangle_.push_back(static_cast<int>(num_cells_));
}

void SurfaceCells::add(TriangleSoup& soup, const CellKind& kind, std::span<const int> nodes) {
    const std::span<const int> at = kind.nodes == 0 ? nodes : nodes.first(static_cast<std::size_t>(kind.corners));
    const std::span<const int> middles = nodes.subspan(at.size());
    middles_.insert(middles_.end(), middles.begin(), middles.end());
    switch (kind.shape) {
        case Shape::Lines:
            for (std::size_t i = 1; i < at.size(); ++i) {
                soup.edges.push_back({at[i - 1], at[i]});
                cell_of_edge_.push_back(static_cast<int>(num_cells_));
            }
            break;
        case Shape::Polygon:
            for (std::size_t i = 2; i < at.size(); ++i) add_triangle(soup, at[0], at[i - 1], at[i]);
            break;
        case Shape::Pixel:
            add_triangle(soup, at[0], at[1], at[3]);
            add_triangle(soup, at[0], at[3], at[2]);
            break;
        case Shape::Strip:
            for (std::size_t i = 2; i < at.size(); ++i)
                i % 2 == 0 ? add_triangle(soup, at[i - 2], at[i - 1], at[i])
                           : add_triangle(soup, at[i - 1], at[i - 2], at[i]);
            break;
        case Shape::Nothing:
        case Shape::Volume:
            break;
    }
    ++num_cells_;
}

Field SurfaceCells::on_triangles(const Field& on_cells) const {
    Field field{on_cells.name, on_cells.components, {}, on_cells.integer};
    const auto n = static_cast<std::size_t>(on_cells.components);
    field.values.reserve(n * cell_of_triangle_.size());
    for (const int cell : cell_of_triangle_)
        for (std::size_t i = 0; i < n; ++i)
            field.values.push_back(on_cells.values[n * static_cast<std::size_t>(cell) + i]);
    return field;
}

void SurfaceCells::drop_middles(MeshData& data) const {
    if (middles_.empty()) return;
    TriangleSoup& soup = data.soup;
    std::vector<char> dropped(soup.points.size(), 0);
    for (const int v : middles_) dropped[static_cast<std::size_t>(v)] = 1;
    for (const Triangle& triangle : soup.triangles)
        for (const int v : triangle) dropped[static_cast<std::size_t>(v)] = 0;
    for (const auto& edge : soup.edges)
        for (const int v : edge) dropped[static_cast<std::size_t>(v)] = 0;

    std::vector<int> number(soup.points.size(), -1);
    std::size_t kept = 0;
    for (std::size_t v = 0; v < soup.points.size(); ++v) {
        if (dropped[v]) continue;
        number[v] = static_cast<int>(kept);
        soup.points[kept] = soup.points[v];
        for (Field& field : data.point_fields)
            for (std::size_t n = static_cast<std::size_t>(field.components), i = 0; i < n; ++i)
                field.values[n * kept + i] = field.values[n * v + i];
        ++kept;
    }
    soup.points.resize(kept);
    for (Field& field : data.point_fields) field.values.resize(kept * static_cast<std::size_t>(field.components));
    for (Triangle& triangle : soup.triangles)
        for (int& v : triangle) v = number[static_cast<std::size_t>(v)];
    for (auto& edge : soup.edges)
        for (int& v : edge) v = number[static_cast<std::size_t>(v)];
}

}  // namespace gradus::io
