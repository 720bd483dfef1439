// gradus info: what is in a file, and what is wrong with it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands.hpp"
#include "describe.hpp"
#include "fields.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/quality/statistics.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string file;
    bool repair = false;
    std::optional<double> weld;
    std::string out;
    CageChoice cage;
};

int tell(const Options& options, const Description& description) {
    options.session.say(description.text);
    print(options.session, description.json);
    return kMet;
}

int info_of_mesh(const Options& options) {
    if (!options.out.empty()) check_output(options.out, {FileKind::Mesh});
    MeshData data = read_mesh_data(options.file);
    weld_read(options.file, data.soup, options.session);
    Description info = describe_mesh(options.file, data);
    options.session.say(info.text);
    if (options.repair) {
        const RepairOptions weld =
            options.weld ? RepairOptions{.weld_tolerance = *options.weld} : default_repair(data.soup);
        if (weld.weld_tolerance > 0 && weld.only_open)
            options.session.say(fmt::format("vertices at open edges within {:.3g} of the diagonal are taken for one\n",
                                            weld.weld_tolerance));
        const Repaired repaired = repair(data.soup, weld);
        const MeshData result{repaired.soup, follow(data.point_fields, repaired.point_source),
                              follow(data.cell_fields, repaired.triangle_source)};
        const Description after = repaired.steps.empty() ? info : describe_mesh("repaired", result);
        options.session.say(text_of(options.file, repaired) + (repaired.steps.empty() ? "" : after.text));
        info.json["repair"] = {{"steps", json_of(repaired.steps)}, {"result", after.json}};
        if (!options.out.empty()) {
            if (result.soup.triangles.empty()) throw Failure(options.file + ": nothing is left to write");
            const bool fields = !result.point_fields.empty() || !result.cell_fields.empty();
            check_holds(options.out, result.soup.points, result.soup.triangles);
            if (holds_fields(options.out))
                write_mesh_data(options.out, result);
            else
                write_mesh(options.out, result.soup);
            options.session.say(
                "wrote " + options.out +
                (fields && !holds_fields(options.out) ? " without the fields; .msh .ply .vtu can hold them\n" : "\n"));
        }
    }
    print(options.session, info.json);
    return kMet;
}

// --- sizes ---

int info_of_solution(const Options& options, const std::vector<Field>& fields) {
    const std::size_t count = fields[0].values.size() / static_cast<std::size_t>(fields[0].components);
    options.session.say(fmt::format("{}: fields at {} vertices: {}\n", options.file, grouped(count), names_of(fields)));
    print(options.session, {{"kind", "fields"}, {"count", count}, {"point_fields", json_of(fields)}});
    return kMet;
}

int info_of_sizes(const Options& options) {
    if (const std::vector<Field> fields = read_solution(options.file); fields.size() > 1 || fields[0].components > 1)
        return info_of_solution(options, fields);
    const std::vector<double> sizes = read_sizes(options.file);
    const auto unset = std::count_if(sizes.begin(), sizes.end(), [](double h) { return std::isinf(h); });
    std::vector<double> given;
    std::copy_if(sizes.begin(), sizes.end(), std::back_inserter(given), [](double h) { return std::isfinite(h); });
    const Summary s = summarise(given);
    options.session.say(fmt::format("{}: {} sizes", options.file, grouped(sizes.size())));
    if (s.count > 0) options.session.say(fmt::format(" from {:.4g} to {:.4g}, median {:.4g}", s.min, s.max, s.median));
    options.session.say(unset > 0 ? fmt::format("; {} not set\n", grouped(static_cast<long long>(unset))) : "\n");
    print(options.session, {{"kind", "sizes"},
                            {"count", sizes.size()},
                            {"unset", unset},
                            {"min", s.min},
                            {"median", s.median},
                            {"max", s.max}});
    return kMet;
}

int run_info(const Options& options) {
    if (options.repair && (kind_of(options.file) != FileKind::Mesh || options.cage.is_given()))
        throw UsageError("--repair is for triangle meshes, not for " + options.file);
    if (!options.repair && (!options.out.empty() || options.weld))
        throw UsageError(std::string(options.out.empty() ? "--weld" : "--output") +
                         " is for what is repaired; give --repair too");
    if (options.weld && !(*options.weld >= 0 && *options.weld <= 0.1))
        throw UsageError(fmt::format("--weld {}: must be from 0 to 0.1", *options.weld));
    check(options.cage);
    if (options.cage.is_given()) return tell(options, describe_cage(options.file, options.cage));
    switch (kind_of(options.file)) {
        case FileKind::Patches:
            return tell(options, describe_patches(options.file));
        case FileKind::Mesh:
        case FileKind::ReadMesh:
            return info_of_mesh(options);
        case FileKind::Sizes:
            return info_of_sizes(options);
        case FileKind::SizeView:
        case FileKind::SizedMesh:
        case FileKind::Report:
        case FileKind::Unknown:
            break;
    }
    throw UsageError(options.file + ": unknown extension \"" + extension_of(options.file) +
                     "\"; known are .bpt .bez, .mesh .meshb .msh .obj .off .ply .stl .vtu .vtp .poly, .sol .solb");
}

}  // namespace

void add_info(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("info", "What is in a file, and what is wrong with it");
    const auto options = std::make_shared<Options>();
    command.add_option("FILE", options->file, "Bezier patches, a triangle mesh or a size map")->required();
    command.add_flag("--repair", options->repair, "Make an oriented manifold of a triangle mesh, and say what changes");
    command.add_option("--weld", options->weld,
                       "With --repair: weld vertices this close, as a fraction of the diagonal (default: those at open "
                       "edges, far below the edges)");
    command.add_option("-o,--output", options->out, "With --repair: the mesh to write")->type_name("OUT");
    add_cages(command, options->cage);
    add_session(command, options->session);
    run_with(command, run, options, run_info);
}

}  // namespace gradus::app
