#include "fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/remesh/carry.hpp"

namespace gradus::app {

namespace {

// Of the fields that write_surface_mesh makes.
const std::set<std::string> kOwnPoints{"size", "shock"}, kOwnCells{"quality"};

// The first of each name that is free; the names of others go to `own`.
std::vector<Field> chosen(std::vector<Field> fields, const std::set<std::string>& taken,
                          std::vector<std::string>& own) {
    std::vector<Field> result;
    std::set<std::string> seen;
    for (Field& field : fields) {
        if (!seen.insert(field.name).second) continue;
        if (taken.contains(field.name))
            own.push_back(field.name);
        else
            result.push_back(std::move(field));
    }
    return result;
}

std::pair<std::vector<std::string>, std::vector<std::string>> by_holding(const std::vector<std::string>& outputs) {
    std::vector<std::string> with, without;
    for (const std::string& path : outputs) (holds_fields(path) ? with : without).push_back(path);
    return {with, without};
}

void add_solution(const std::string& path, const std::string& in, std::size_t vertices, std::vector<Field>& fields) {
    for (Field& field : read_solution(path, vertices)) {
        const bool twice =
            std::any_of(fields.begin(), fields.end(), [&](const Field& other) { return other.name == field.name; });
        if (twice || kOwnPoints.contains(field.name))
            throw Failure(fmt::format("{}: {} has a field {} already; give the file another name", path,
                                      twice ? in : "the mesh", field.name));
        fields.push_back(std::move(field));
    }
}

}  // namespace

Fields load_fields(const std::string& path, bool repair, const std::vector<std::string>& solutions) {
    for (const std::string& solution : solutions)
        if (kind_of(solution) != FileKind::Sizes)
            throw UsageError(fmt::format("--field {}: unknown extension \"{}\"; use one of .sol .solb", solution,
                                         extension_of(solution)));
    Fields fields;
    // Other formats have none: they need not be read again.
    if (solutions.empty() && !holds_fields(path) && extension_of(path) != ".vtp") return fields;
    MeshData data = read_mesh_data(path);
    // Labels are carried as such.
    if (!data.soup.labels.empty())
        std::erase_if(data.cell_fields, [](const Field& field) { return field.name == "label"; });
    fields.points = chosen(std::move(data.point_fields), kOwnPoints, fields.own);
    fields.cells = chosen(std::move(data.cell_fields), kOwnCells, fields.own);
    for (const std::string& solution : solutions) add_solution(solution, path, data.soup.points.size(), fields.points);
    if (repair && fields.size() > 0) {
        const Repaired repaired = gradus::repair(data.soup, default_repair(data.soup));
        fields.points = follow(fields.points, repaired.point_source);
        fields.cells = follow(fields.cells, repaired.triangle_source);
    }
    return fields;
}

Fields carry(const Triangulation& surface, const Fields& fields, const SurfaceMesh& mesh,
             const std::vector<std::string>& outputs) {
    if (by_holding(outputs).first.empty()) return {};
    return {carry_point_fields(surface, fields.points, mesh), carry_cell_fields(surface, fields.cells, mesh), {}};
}

std::string names_of(const std::vector<Field>& fields) {
    std::vector<std::string> names;
    for (const Field& field : fields)
        names.push_back(field.components == 1 ? field.name : fmt::format("{} ({})", field.name, field.components));
    return fmt::format("{}", fmt::join(names, ", "));
}

Json json_of(const std::vector<Field>& fields) {
    Json json = Json::array();
    for (const Field& field : fields) json.push_back({{"name", field.name}, {"components", field.components}});
    return json;
}

std::string text_of(const Fields& fields, const std::vector<std::string>& outputs) {
    std::string text;
    if (fields.size() > 0) {
        std::vector<std::string> kinds;
        if (!fields.points.empty()) kinds.push_back(names_of(fields.points) + " on points");
        if (!fields.cells.empty()) kinds.push_back(names_of(fields.cells) + " on triangles");
        const auto [with, without] = by_holding(outputs);
        text = fmt::format("fields: {}", fmt::join(kinds, "; "));
        text += with.empty() ? ", carried nowhere\n" : fmt::format(", carried to {}\n", fmt::join(with, " "));
        if (!without.empty())
            text += fmt::format("fields: {} cannot hold {}; .msh .ply .vtu can\n", fmt::join(without, " "),
                                fields.size() == 1 ? "this field" : fmt::format("these {} fields", fields.size()));
    }
    if (!fields.own.empty())
        text += fmt::format("fields: {} left behind, as the mesh has its own\n", fmt::join(fields.own, ", "));
    return text;
}

Json json_of(const Fields& fields, const std::vector<std::string>& outputs) {
    const auto [with, without] = by_holding(outputs);
    return {{"points", json_of(fields.points)},
            {"cells", json_of(fields.cells)},
            {"carried_to", with},
            {"not_held_by", without},
            {"left_behind", fields.own}};
}

}  // namespace gradus::app
