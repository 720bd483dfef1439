// gradus grade: bounds how fast the sizes on a mesh change.
#include <fmt/format.h>

#include "adaption.hpp"
#include "commands.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "json.hpp"
#include "show.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string mesh, sizes, out;
    GradationChoice gradation;
};

// What one sweep says of the certificate; nothing where the method gives none.
struct Proof {
    bool given = false;
    std::optional<std::string> fault;
};

Proof prove(const TriMesh& mesh, const GradationOptions& options, std::span<const double> input,
            std::span<const double> sizes, const GradationResult& result) {
    if (options.method != GradationMethod::Exact || (options.shock && options.variation)) return {};
    return {true, options.shock
                      ? check_shock_certificate(mesh, *options.shock, input, sizes, result.certificate)
                      : check_variation_certificate(mesh, *options.variation, input, sizes, result.certificate)};
}

std::string proof_line(const Proof& proof) {
    if (!proof.given) return "";
    return proof.fault ? "  certificate FAILS: " + *proof.fault + "\n"
                       : "  certificate holds: every size is the input, or as large as a smaller neighbour allows\n";
}

// Whether a file has one number per vertex, or more.
bool has_sizes(const std::string& path, std::size_t vertices) {
    const std::vector<Field> fields = read_solution(path, vertices);
    return fields.size() == 1 && fields[0].components == 1;
}

int grade_metrics(const Options& options, const TriangleSoup& soup, const TriMesh& mesh, Stages& stages) {
    const TensorGradationOptions gradation = *tensor_gradation_of(options.gradation, std::nullopt);
    check_output(options.out, {FileKind::Sizes});
    const std::vector<Tensor> input = read_metrics(options.sizes, soup.points.size());
    std::vector<Tensor> metrics = input;
    const TensorGradationResult result = stages.run("gradation", [&] { return grade(mesh, metrics, gradation); });
    std::optional<std::string> fault;
    if (gradation.method == TensorGradationMethod::Shape)
        fault = check_shape_certificate(mesh, gradation, input, metrics, result.parent);
    else if (gradation.method != TensorGradationMethod::Paper)
        fault = check_intersection_certificate(mesh, gradation, input, metrics);
    write_metrics(options.out, metrics, soup.dimension);

    options.session.say(fmt::format("{}: {} vertices, {} triangles\n", options.mesh, grouped(soup.points.size()),
                                    grouped(soup.triangles.size())));
    options.session.say(text_of(gradation, result, metrics.size()));
    if (gradation.method != TensorGradationMethod::Paper)
        options.session.say(fault ? "  certificate FAILS: " + *fault + "\n" : "  certificate holds\n");
    options.session.say(fmt::format("wrote {}\n", options.out));
    Json json = json_of(gradation, result);
    json["vertices"] = metrics.size();
    json["certificate"] = gradation.method == TensorGradationMethod::Paper ? Json(nullptr) : Json(!fault);
    json["stages"] = json_of(stages.times());
    json["files"] = {options.out};
    print(options.session, json);
    return result.met && !fault ? kMet : kFailed;
}

int run_grade(const Options& options) {
    check_output(options.out, {FileKind::Sizes, FileKind::SizeView, FileKind::SizedMesh});
    if (kind_of(options.sizes) == FileKind::Sizes && kind_of(options.out) == FileKind::Sizes) {
        Stages stages(options.session);
        const TriangleSoup soup = stages.run("reading", [&] { return read_mesh(options.mesh); });
        const TriMesh mesh = manifold_of(options.mesh, soup);
        if (!has_sizes(options.sizes, soup.points.size())) return grade_metrics(options, soup, mesh, stages);
    }
    const GradationOptions gradation = *gradation_of(options.gradation, std::nullopt);
    Stages stages(options.session);
    const TriangleSoup soup = stages.run("reading", [&] { return read_mesh(options.mesh); });
    const TriMesh mesh = manifold_of(options.mesh, soup);
    const std::vector<double> input = read_sizes(options.sizes, soup.points.size());

    std::vector<double> sizes = input;
    const GradationResult result = stages.run("gradation", [&] { return grade(mesh, sizes, gradation); });
    const Proof proof = stages.run("proof", [&] { return prove(mesh, gradation, input, sizes, result); });
    write_size_map(options.out, soup, sizes);

    options.session.say(fmt::format("{}: {} vertices, {} triangles\n", options.mesh, grouped(soup.points.size()),
                                    grouped(soup.triangles.size())));
    options.session.say(text_of(gradation, result, sizes.size()) + proof_line(proof));
    options.session.say(fmt::format("wrote {}\n", options.out));
    Json json = json_of(gradation, result);
    json["vertices"] = sizes.size();
    json["certificate"] = proof.given ? Json(!proof.fault) : Json(nullptr);
    json["stages"] = json_of(stages.times());
    json["files"] = {options.out};
    print(options.session, json);
    return result.met && !proof.fault ? kMet : kFailed;
}

}  // namespace

void add_grade(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("grade", "Bound how fast the sizes on a mesh change");
    const auto options = std::make_shared<Options>();
    command
        .add_option("BG", options->mesh,
                    "Triangle mesh that carries the sizes: .mesh .meshb .msh .obj .off .ply .stl .vtu .vtp .poly")
        ->required();
    command.add_option("--size", options->sizes, "One size, or one metric, per vertex of BG")
        ->required()
        ->type_name("MAP.sol");
    command
        .add_option("-o,--output", options->out,
                    "Graded sizes; may be MAP.sol itself; .pos or .msh for Gmsh, .vtu, .ply with colours")
        ->required()
        ->type_name("OUT.sol");
    add_gradation(command, options->gradation, GradationNeeded::Yes);
    add_session(command, options->session);
    run_with(command, run, options, run_grade);
}

}  // namespace gradus::app
