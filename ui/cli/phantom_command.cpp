#include "ui/cli/phantom_files.h"

#include "mesh/base/error.h"
#include "ui/cli/arguments.h"
#include "ui/cli/command.h"
#include "ui/cli/field_files.h"

#include <Eigen/Geometry>

#include <memory>
#include <numbers>

namespace retractor::cli {

namespace {

    struct PhantomOptions {
        std::string kind, out, spacing, shift = "0,0,0", turn = "0,0,0";
        ThoraxParameters thorax;
        BlockParameters block;
        bool nrrd = false;
    };

    Mat3 rotation_of(const Vec3& degrees)
    {
        const Vec3 r = degrees * std::numbers::pi / 180.0;
        return (Eigen::AngleAxisd(r.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(r.y(), Vec3::UnitY())
            * Eigen::AngleAxisd(r.x(), Vec3::UnitX()))
            .toRotationMatrix();
    }

    Outcome make_phantom(PhantomOptions options, const Job& job)
    {
        if (!options.spacing.empty())
            options.thorax.spacing_mm = options.block.spacing_mm = parse_point(options.spacing, "--spacing");
        options.block.noise_hu = options.thorax.noise_hu;
        options.block.seed = options.thorax.seed;
        Phantom phantom = options.kind == "thorax" ? make_thorax_phantom(options.thorax, job)
                                                   : make_block_phantom(options.block, job);
        const Vec3 shift = parse_point(options.shift, "--shift");
        const Vec3 turn = parse_point(options.turn, "--turn");
        if (!shift.isZero(0.0) || !turn.isZero(0.0))
            phantom = transformed(phantom, rotation_of(turn), shift);
        const PhantomFiles files = write_phantom(options.out, phantom, options.nrrd, job);
        Outcome outcome;
        outcome.document = { { "ct", files.ct.string() }, { "labels", files.labels.string() }, { "frame", "LPS" },
            { "size", phantom.ct.grid.size } };
        outcome.text = "CT:     " + files.ct.string() + "\nlabels: " + files.labels.string() + "\n";
        return outcome;
    }

} // namespace

PhantomFiles write_phantom(const std::filesystem::path& folder, const Phantom& phantom, bool as_nrrd, const Job& job)
{
    make_folder(folder);
    PhantomFiles files { as_nrrd ? folder / "ct.nrrd" : folder / "ct", folder / "labels.nrrd" };
    job.report("write phantom", 0.0);
    if (as_nrrd)
        write_volume(files.ct, phantom.ct);
    else
        write_dicom_series(files.ct, phantom.ct);
    job.report("write phantom", 0.7);
    write_label_volume(files.labels, phantom.labels);
    return files;
}

void add_phantom_command(Commands& commands)
{
    auto options = std::make_shared<PhantomOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "phantom", "Make a synthetic patient: a DICOM CT series (or NRRD) and its labels");
    command->footer("Example: retractor phantom thorax --out patient --width 360 --seed 7");
    command->add_option("kind", options->kind, "thorax or block")
        ->required()
        ->check(CLI::IsMember({ "thorax", "block" }));
    command->add_option("--out", options->out, "Folder to write to")->required();
    command->add_flag("--nrrd", options->nrrd, "Write the CT as NRRD instead of a DICOM series");
    command->add_option("--width", options->thorax.width_mm, "Thorax: left to right, mm")->capture_default_str();
    command->add_option("--depth", options->thorax.depth_mm, "Thorax: front to back, mm")->capture_default_str();
    command->add_option("--height", options->thorax.height_mm, "Thorax: imaged length, mm")->capture_default_str();
    command->add_option("--fat", options->thorax.fat_mm, "Thorax: subcutaneous fat, mm")->capture_default_str();
    command->add_option("--aneurysm", options->thorax.aneurysm_diameter_mm, "Thorax: diameter of the aneurysm, mm")
        ->capture_default_str();
    command->add_option("--spacing", options->spacing, "Voxel spacing x,y,z in mm");
    command->add_option("--fov", options->thorax.field_of_view_mm,
        "Thorax: square field of view, mm, as a scanner's (default: the body and 8 mm)");
    command->add_option("--noise", options->thorax.noise_hu, "CT noise, HU")->capture_default_str();
    command->add_option("--seed", options->thorax.seed, "Seed of the noise")->capture_default_str();
    command->add_option("--turn", options->turn, "Rotate the patient in the scanner: degrees about x,y,z")
        ->capture_default_str();
    command->add_option("--shift", options->shift, "Move the patient in the scanner: x,y,z in mm")
        ->capture_default_str();
    command->callback(
        [&commands, options] { commands.run = [options](const Job& job) { return make_phantom(*options, job); }; });
}

} // namespace retractor::cli
