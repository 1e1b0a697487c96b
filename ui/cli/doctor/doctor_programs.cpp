// Checks that need other programs or a picture: drawing by OSMesa and EGL, the window, CalculiX.

#include "ui/cli/doctor/doctor_checks.h"

#include "mesh/base/error.h"
#include "planner/case/patient.h"
#include "ui/cli/framework/run_program.h"
#include "ui/scene/vtk/render.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    fs::path program_beside(const char* name) { return fs::read_symlink("/proc/self/exe").parent_path() / name; }

    constexpr std::chrono::seconds kLimit(20); // starting and drawing one picture takes a second

    std::string end_of(const ProgramRun& run)
    {
        return run.timed_out    ? " does not end within " + std::to_string(kLimit.count()) + " s"
            : run.exit_code < 0 ? " dies"
                                : " fails";
    }

    std::string advice_for(std::string_view backend)
    {
        return backend == "osmesa" ? "apt install libosmesa6" : "apt install libegl1 libegl-mesa0 libgl1-mesa-dri";
    }

    /// Draws a ball on a black background and checks the picture: light in the middle, dark in the corner.
    void draw_ball(OffscreenRenderer& renderer)
    {
        constexpr int kSize = 64;
        constexpr double kRadiusMm = 40.0;
        Scene scene;
        scene.surfaces.push_back({ .name = "ball",
            .mesh = std::make_shared<const TriMesh>(planner::sphere_surface(Vec3::Zero(), kRadiusMm)),
            .look = { .color = { 0.9, 0.9, 0.9 } } });
        scene.camera = { .parallel = true, .half_height_mm = 60.0 };
        scene.background_low = scene.background_high = { 0.0, 0.0, 0.0 };
        scene.orientation_marker = scene.scale_bar = false;
        const Image image
            = renderer.render({ .width = kSize, .height = kSize, .viewports = { { .scene = std::move(scene) } } });
        const auto red = [&](int x, int y) { return image.rgb.at(3 * static_cast<std::size_t>(y * kSize + x)); };
        if (red(kSize / 2, kSize / 2) < 100 || red(1, 1) > 20)
            throw IoError("the picture of a ball is wrong");
    }

    Health health_of(const std::string& text)
    {
        return text == "ok" ? Health::ok : text == "warning" ? Health::warning : Health::missing;
    }

} // namespace

Finding check_own_drawing()
{
    Finding finding { .topic = "drawing", .name = "off-screen", .essential = true };
    try {
        std::unique_ptr<OffscreenContext> context = make_offscreen_context();
        finding.name = std::string(context->backend());
        finding.advice = advice_for(context->backend());
        context->make_current();
        finding.found = context->renderer();
        OffscreenRenderer renderer(std::move(context));
        draw_ball(renderer);
        finding.advice.clear();
    } catch (const Error& error) {
        finding.health = Health::missing;
        finding.found += (finding.found.empty() ? "" : ": ") + std::string(error.what());
        if (finding.advice.empty())
            finding.advice = advice_for(error.where());
    }
    return finding;
}

std::vector<Finding> check_other_drawing()
{
    const bool is_egl = fs::read_symlink("/proc/self/exe").filename() == "retractor-egl";
    const std::string backend = is_egl ? "osmesa" : "egl";
    const fs::path other = program_beside(is_egl ? "retractor" : "retractor-egl");
    Finding finding { .topic = "drawing",
        .name = backend,
        .health = Health::missing,
        .found = {},
        .advice = advice_for(backend) + "; only for --backend " + backend };
    if (!fs::exists(other)) {
        finding.found = other.string() + " is not there";
        finding.advice = "install the whole package; only for --backend " + backend;
        return { finding };
    }
    const ProgramRun run = run_program({ other.string(), "--json", "doctor", "--own-drawing" }, kLimit);
    const Json document = Json::parse(run.out, nullptr, false);
    if (document.is_discarded() || !document.contains("checks") || document["checks"].empty()) {
        finding.found = other.string() + end_of(run);
        return { finding };
    }
    const Json& check = document["checks"][0];
    finding.found = check.value("found", "");
    finding.health = health_of(check.value("status", ""));
    if (finding.health == Health::ok)
        finding.advice.clear();
    return { finding };
}

std::vector<Finding> check_window()
{
    const fs::path program = program_beside("retractor-workstation");
    Finding finding { .topic = "window", .name = "retractor-workstation" };
    if (!fs::exists(program)) {
        finding.health = Health::missing;
        finding.found = "is not there";
        finding.advice = "needed only for the window: build with Qt 5, or install the whole package";
        return { finding };
    }
    ProgramRun run = run_program({ program.string(), "--version" }, kLimit);
    run.out.erase(std::remove(run.out.begin(), run.out.end(), '\n'), run.out.end());
    if (run.exit_code != 0) {
        finding.health = Health::missing;
        finding.found = "does not start";
        finding.advice = "run it by hand to see which library is missing";
        return { finding };
    }
    finding.found = run.out;
    Finding display { .topic = "window", .name = "display" };
    for (const char* name : { "WAYLAND_DISPLAY", "DISPLAY" })
        if (const char* value = std::getenv(name); value != nullptr && *value != '\0')
            display.found = std::string(name) + "=" + value;
    if (display.found.empty()) {
        display.health = Health::warning;
        display.found = "none";
        display.advice = "the window needs one; pictures by retractor render do not";
    }
    Finding fonts { .topic = "window", .name = "fonts" };
    std::error_code error;
    int count = 0;
    for (fs::recursive_directory_iterator entry("/usr/share/fonts", error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string suffix = entry->path().extension().string();
        count += suffix == ".ttf" || suffix == ".otf" || suffix == ".ttc" || suffix == ".pfb" ? 1 : 0;
    }
    fonts.found = std::to_string(count) + " in /usr/share/fonts";
    if (count == 0) {
        fonts.health = Health::warning;
        fonts.advice = "the window would show no text: apt install fonts-dejavu-core (pictures bring their own)";
    }
    return { finding, display, fonts };
}

std::vector<Finding> check_references()
{
    Finding finding { .topic = "reference", .name = "CalculiX (ccx)" };
    const fs::path ccx = program_on_path("ccx");
    if (ccx.empty()) {
        finding.health = Health::missing;
        finding.found = "not on the PATH";
        finding.advice = "apt install calculix-ccx; only for retractor plan --reference ccx";
        return { finding };
    }
    const ProgramRun run = run_program({ ccx.string(), "-v" }, kLimit);
    const std::size_t version = run.out.find("ersion");
    if (version == std::string::npos) {
        finding.health = Health::missing;
        finding.found = ccx.string() + end_of(run);
        finding.advice = "run it by hand to see what is wrong; only for retractor plan --reference ccx";
        return { finding };
    }
    finding.found = ccx.string() + ", v" + run.out.substr(version, run.out.find_first_of(",\n", version) - version);
    return { finding };
}

} // namespace retractor::ui::cli
