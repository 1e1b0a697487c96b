#include "ui/cli/case/phantom_files.h"

#include "datasets/phantoms/abdomen_phantom.h"
#include "datasets/phantoms/aorta_phantom.h"
#include "datasets/phantoms/palpation_scene_file.h"
#include "mesh/base/error.h"
#include "ui/cli/case/touchable_phantoms.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/out_folder.h"

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>

#include <memory>
#include <numbers>
#include <optional>

namespace retractor::ui::cli {

namespace {

    struct PhantomOptions {
        std::string kind, out, spacing, shift = "0,0,0", turn = "0,0,0";
        datasets::ThoraxParameters thorax;
        datasets::BlockParameters block;
        datasets::AortaParameters aorta;
        std::string shape = "arch", region = "30x360";
        std::optional<double> edge_mm;
        bool nrrd = false, touchable = false;
    };

    Mat3 rotation_of(const Vec3& degrees)
    {
        const Vec3 r = degrees * std::numbers::pi / 180.0;
        return (Eigen::AngleAxisd(r.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(r.y(), Vec3::UnitY())
            * Eigen::AngleAxisd(r.x(), Vec3::UnitX()))
            .toRotationMatrix();
    }

    /// Parses "30x120", a length in mm and an angle in degrees, or "none".
    datasets::StiffRegion parse_region(const std::string& text)
    {
        if (text == "none")
            return { 0.0, 360.0 };
        const std::size_t x = text.find('x');
        if (x == std::string::npos)
            throw InputError("is LENGTHxANGLE, such as 30x120, or none: \"" + text + '"', "--region");
        return { parse_numbers(text.substr(0, x), 1, "--region")[0],
            parse_numbers(text.substr(x + 1), 1, "--region")[0] };
    }

    void refuse_voxel_options(const PhantomOptions& options)
    {
        if (options.shift != "0,0,0" || options.turn != "0,0,0" || !options.spacing.empty() || options.nrrd)
            throw InputError("tissue to palpate has no CT: use --shift, --turn, --spacing and --nrrd only with thorax, "
                             "abdomen and block",
                "phantom " + options.kind);
    }

    Outcome make_aorta(PhantomOptions options, const Job& job)
    {
        refuse_voxel_options(options);
        options.aorta.shape
            = options.shape == "arch" ? datasets::AortaParameters::Shape::arch : datasets::AortaParameters::Shape::tube;
        options.aorta.region = parse_region(options.region);
        job.report("mesh", 0.0);
        const datasets::PalpationScene scene = datasets::make_aorta_phantom(options.aorta);
        make_folder(options.out);
        const std::filesystem::path file = std::filesystem::path(options.out) / "aorta.json";
        datasets::write_palpation_scene(file, scene);
        Outcome outcome;
        Json sites = Json::array();
        for (const datasets::TouchSite& site : scene.sites)
            sites.push_back(site.name);
        outcome.document
            = { { "scene", file.string() }, { "mesh", (std::filesystem::path(options.out) / "aorta.vtu").string() },
                  { "frame", "LPS" }, { "vertices", scene.body.mesh.vertex_count() },
                  { "tets", scene.body.mesh.tet_count() }, { "sites", sites } };
        outcome.text = "scene: " + file.string() + "\n" + std::to_string(scene.body.mesh.vertex_count()) + " vertices, "
            + std::to_string(scene.body.mesh.tet_count()) + " tetrahedra\n";
        return outcome;
    }

    /// Makes a body of tetrahedra with its sites.
    Outcome make_touchable(const PhantomOptions& options, const Job& job)
    {
        refuse_voxel_options(options);
        const datasets::PalpationScene scene = options.kind == "liver"
            ? make_liver_scene(options.edge_mm.value_or(12.0), job)
            : options.kind == "abdomen" ? make_abdomen_scene(options.edge_mm.value_or(16.0), job)
                                        : make_sheet_scene();
        make_folder(options.out);
        const std::filesystem::path file = std::filesystem::path(options.out) / (options.kind + ".json");
        datasets::write_palpation_scene(file, scene);
        Outcome outcome;
        outcome.document
            = { { "scene", file.string() }, { "frame", "LPS" }, { "vertices", scene.body.mesh.vertex_count() },
                  { "tets", scene.body.mesh.tet_count() }, { "sites", Json::array() } };
        for (const datasets::TouchSite& site : scene.sites)
            outcome.document["sites"].push_back(site.name);
        outcome.text = "scene: " + file.string() + "\n" + std::to_string(scene.body.mesh.vertex_count()) + " vertices, "
            + std::to_string(scene.body.mesh.tet_count()) + " tetrahedra\n";
        return outcome;
    }

    datasets::Phantom make_voxels(const PhantomOptions& options, const Job& job)
    {
        if (options.kind == "thorax")
            return datasets::make_thorax_phantom(options.thorax, job);
        if (options.kind == "block")
            return datasets::make_block_phantom(options.block, job);
        datasets::AbdomenParameters abdomen;
        if (!options.spacing.empty())
            abdomen.spacing_mm = options.block.spacing_mm;
        abdomen.noise_hu = options.thorax.noise_hu;
        abdomen.seed = options.thorax.seed;
        return datasets::make_abdomen_phantom(abdomen, job);
    }

    Outcome make_phantom(PhantomOptions options, const Job& job)
    {
        if (options.touchable && options.kind != "abdomen")
            throw InputError(
                "works only with abdomen; aorta, liver and sheet are always tissue to palpate", "--touchable");
        if (options.kind == "liver" || options.kind == "sheet" || options.touchable)
            return make_touchable(options, job);
        if (options.kind == "aorta")
            return make_aorta(std::move(options), job);
        if (!options.spacing.empty())
            options.thorax.spacing_mm = options.block.spacing_mm = parse_point(options.spacing, "--spacing");
        options.block.noise_hu = options.thorax.noise_hu;
        options.block.seed = options.thorax.seed;
        datasets::Phantom phantom = make_voxels(options, job);
        const Vec3 shift = parse_point(options.shift, "--shift");
        const Vec3 turn = parse_point(options.turn, "--turn");
        if (!shift.isZero(0.0) || !turn.isZero(0.0))
            phantom = datasets::transformed(phantom, rotation_of(turn), shift);
        const PhantomFiles files = write_phantom(options.out, phantom, options.nrrd, job);
        Outcome outcome;
        outcome.document = { { "ct", files.ct.string() }, { "labels", files.labels.string() }, { "frame", "LPS" },
            { "size", phantom.ct.grid.size } };
        outcome.text = "CT:     " + files.ct.string() + "\nlabels: " + files.labels.string() + "\n";
        return outcome;
    }

} // namespace

PhantomFiles write_phantom(
    const std::filesystem::path& folder, const datasets::Phantom& phantom, bool as_nrrd, const Job& job)
{
    make_folder(folder);
    PhantomFiles files { as_nrrd ? folder / "ct.nrrd" : folder / "ct", folder / "labels.nrrd" };
    job.report("write phantom", 0.0);
    if (as_nrrd)
        datasets::write_volume(files.ct, phantom.ct);
    else
        datasets::write_dicom_series(files.ct, phantom.ct);
    job.report("write phantom", 0.7);
    datasets::write_label_volume(files.labels, phantom.labels);
    return files;
}

void add_phantom_command(Commands& commands)
{
    auto options = std::make_shared<PhantomOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "phantom", "Make a synthetic patient (a CT as a DICOM series or NRRD, with labels), or tissue to palpate");
    command->footer("Example: retractor phantom thorax --out patient --width 360 --seed 7");
    command
        ->add_option("kind", options->kind,
            "thorax, block or abdomen: a CT with labels; aorta, liver or sheet: tissue to palpate")
        ->required()
        ->check(CLI::IsMember({ "thorax", "block", "abdomen", "aorta", "liver", "sheet" }));
    command->add_option("--out", options->out, "Folder to write to")->required();
    command->add_option(
        "--edge", options->edge_mm, "Edge length of the tetrahedra, mm (default: liver 12, abdomen 16)");
    command->add_flag("--touchable", options->touchable, "Abdomen: make tissue to palpate instead of a CT");
    command->add_flag("--nrrd", options->nrrd, "Write the CT as NRRD instead of a DICOM series");
    command->add_option("--width", options->thorax.width_mm, "Thorax: width from left to right, mm")
        ->capture_default_str();
    command->add_option("--depth", options->thorax.depth_mm, "Thorax: depth from front to back, mm")
        ->capture_default_str();
    command->add_option("--height", options->thorax.height_mm, "Thorax: imaged length, mm")->capture_default_str();
    command->add_option("--fat", options->thorax.fat_mm, "Thorax: thickness of the subcutaneous fat, mm")
        ->capture_default_str();
    command->add_option("--aneurysm", options->thorax.aneurysm_diameter_mm, "Thorax: diameter of the aneurysm, mm")
        ->capture_default_str();
    command->add_option("--spacing", options->spacing, "Voxel spacing x,y,z in mm");
    command->add_option("--fov", options->thorax.field_of_view_mm,
        "Thorax: edge of the square field of view, mm (default: the body and 8 mm)");
    command->add_option("--noise", options->thorax.noise_hu, "CT noise, HU")->capture_default_str();
    command->add_option("--seed", options->thorax.seed, "Seed of the noise")->capture_default_str();
    command->add_option("--turn", options->turn, "Rotate the patient in the scanner: degrees about x,y,z")
        ->capture_default_str();
    command->add_option("--shift", options->shift, "Move the patient in the scanner: x,y,z in mm")
        ->capture_default_str();
    command->add_option("--shape", options->shape, "Aorta: arch, or tube (straight, 100 mm)")
        ->check(CLI::IsMember({ "arch", "tube" }))
        ->capture_default_str();
    command
        ->add_option(
            "--region", options->region, "Aorta: sclerotic region, its length in mm x its angle in degrees, or none")
        ->capture_default_str();
    command
        ->add_option("--normal", options->aorta.normal_MPa, "Aorta: Young's modulus outside the sclerotic region, MPa")
        ->capture_default_str();
    command
        ->add_option("--sclerotic", options->aorta.sclerotic_MPa, "Aorta: Young's modulus of the sclerotic region, MPa")
        ->capture_default_str();
    command->add_option("--poisson", options->aorta.poissons_ratio, "Aorta: Poisson's ratio")->capture_default_str();
    command->add_option("--around", options->aorta.around, "Aorta: elements round the vessel")->capture_default_str();
    command->add_option("--through", options->aorta.through, "Aorta: elements through the wall of the vessel")
        ->capture_default_str();
    command->add_option("--along", options->aorta.along, "Aorta: elements along the vessel")->capture_default_str();
    commands.on(command, [options](const Job& job) { return make_phantom(*options, job); });
}

} // namespace retractor::ui::cli
