// The program retractor-workstation: opens a window to plan a case, or a window to palpate tissue.

#include "datasets/phantoms/palpation_scene_file.h"
#include "haptics/hand/hand_file.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable.h"
#include "ui/workstation/benchmark/window_benchmark.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/palpation/palpation_window.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/theme.h"
#include "ui/workstation/view/window_place.h"

#include <CLI/CLI.hpp>

#include <QApplication>
#include <QLibraryInfo>
#include <QSurfaceFormat>
#include <QTimer>
#include <QTranslator>

#include <chrono>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

namespace {

using namespace retractor;
using namespace retractor::ui;

struct Options {
    std::string case_file;
    std::string approach;
    std::string view = "surgeon", wall = "solid";
    std::string screenshot;
    std::string model = "fem";
    std::string hand;
    std::string structure;
    std::string language;
    bool plan = false;
    bool before = false;
    bool palpate = false;
    bool benchmark = false;
};

/// Parses the arguments. @returns the exit code when the program ends here; nothing when it continues
std::optional<int> parse(int argc, char** argv, Options& options)
{
    CLI::App app { "Shows a case and plans its approaches in a window, or lets you palpate a scene. Not a medical "
                   "device.",
        "retractor-workstation" };
    app.set_version_flag("--version", std::string("retractor-workstation ") + RETRACTOR_VERSION);
    app.add_option("case", options.case_file,
           "case.json, the folder of a case.json, or a palpation scene (made by retractor phantom or retractor "
           "palpable)")
        ->type_name("CASE.json|SCENE.json");
    auto* approach = app.add_option("--approach", options.approach, "Select this approach")->type_name("NAME");
    auto* view = app.add_option("--view", options.view, "View that the window shows first")
                     ->check(CLI::IsMember({ "surgeon", "overview", "slices", "incision", "compare" }))
                     ->capture_default_str();
    auto* wall = app.add_option("--wall", options.wall, "How the body's wall is drawn")
                     ->check(CLI::IsMember({ "solid", "see-through", "hidden" }))
                     ->capture_default_str();
    auto* plan = app.add_flag("--plan", options.plan, "Plan the selected approach at once");
    app.add_option("--screenshot", options.screenshot,
           "Plan the selected approach, or prepare the tissue of a palpation scene; then save the window as PNG and "
           "quit. Without a case: the start page")
        ->type_name("FILE.png");
    auto* model = app.add_option("--model", options.model, "Tissue model for palpation")
                      ->check(CLI::IsMember(planner::tissue_models()))
                      ->capture_default_str();
    auto* hand = app.add_option("--hand", options.hand,
                        "OBJ file of the hand that is shown during palpation (see docs/user/palpation.md)")
                     ->type_name("FILE.obj");
    app.add_option("--palpate", options.structure, "Palpate this structure (label) of the case, e.g. aorta")
        ->type_name("LABEL");
    app.add_option("--language", options.language,
           "Language of the window (default: the one chosen in its menu Help, else the system's)")
        ->check(CLI::IsMember({ "en", "ja" }));
    auto* before = app.add_flag(
        "--before", options.before, "With --screenshot: show the patient before opening, without planning");
    auto* benchmark = app.add_flag("--benchmark", options.benchmark,
                             "Measure how the picture follows mouse and wheel, print pictures a second and delays as "
                             "JSON, and quit; with --plan, measure the opened field too")
                          ->excludes("--screenshot");
    app.footer(
        "Example: retractor-workstation patient/case.json --approach median --view overview\n"
        "Keys: 1 surgeon's eye, 2 overview, 3 slices (the wheel steps through them, Shift+1 to Shift+4 change\n"
        "their greys), 4 slices along and across the incision, 5 compare the planned approaches, R measure,\n"
        "T target at the marked place, O opened field or patient before, W wall see-through, V cut away,\n"
        "6 and 7 endoscope.\n"
        "Approaches: N new, D draw an incision on the skin, M move its points (Enter ends), E target and opening,\n"
        "Ctrl+D duplicate, B add neighbours, Ctrl+F search, Delete remove, P plan, Ctrl+P plan a draft,\n"
        "Shift+P plan all, Esc cancel.\n"
        "Cutting: K knife (draw on the skin with the left button), L straight cut between two clicks, H hooks\n"
        "(press on the edge of a wound to set a hook, drag a hook to pull it), X take out, Ctrl+Z undo,\n"
        "Ctrl+Shift+Z redo, Esc discard the stroke. The right button, or Shift and the left button, turns the\n"
        "camera.\n"
        "Palpation: retractor-workstation aorta/aorta.json. The left button presses a fingertip in. Drag to\n"
        "slide the fingertip; turn the wheel while the button is held to press deeper. 1, 2 ... select another\n"
        "finger and leave this finger pressed; Esc lifts all fingers.");
    try {
        app.parse(argc, argv);
        if (options.case_file.empty()
            && !(options.approach.empty() && !options.before && !options.plan && !options.benchmark))
            throw CLI::RequiredError("CASE.json with --approach, --before, --plan or --benchmark");
        options.palpate = datasets::is_palpation_scene(options.case_file) || !options.structure.empty();
        if (!options.structure.empty()
            && (options.case_file.empty() || datasets::is_palpation_scene(options.case_file)))
            throw CLI::ValidationError("--palpate", "needs a case, not a palpation scene");
        for (const CLI::Option* option : { approach, view, wall, plan, before, benchmark })
            if (options.palpate && option->count() > 0)
                throw CLI::ValidationError(option->get_name(),
                    options.structure.empty() ? "needs a case, but the file is a palpation scene"
                                              : "cannot be combined with --palpate");
        for (const CLI::Option* option : { model, hand })
            if (!options.palpate && option->count() > 0)
                throw CLI::ValidationError(option->get_name(), "needs a palpation scene or --palpate");
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    return std::nullopt;
}

WallLook wall_look_of(const std::string& word)
{
    return word == "hidden" ? WallLook::hidden : word == "see-through" ? WallLook::see_through : WallLook::solid;
}

int fail(const std::string& text, int exit_code)
{
    std::fprintf(stderr, "retractor-workstation: %s\n", text.c_str());
    return exit_code;
}

bool set_in_environment(const char* name)
{
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
}

/// Looks for a display, because Qt aborts the process without one.
bool has_display()
{
    return set_in_environment("DISPLAY") || set_in_environment("WAYLAND_DISPLAY")
        || set_in_environment("QT_QPA_PLATFORM");
}

/// Waits for the plan, saves the window and quits.
void take_screenshot(MainWindow& window, QTimer& timer, const Options& options)
{
    constexpr int kPollMs = 50;
    QObject::connect(&timer, &QTimer::timeout, &window, [&window, &timer, &options] {
        if (!window.idle())
            return;
        timer.stop();
        const auto* const view = window.model(); // null: the start page
        window.set_view(*view_from_string(options.view));
        if (view != nullptr && view->view() != *view_from_string(options.view) && window.error_line().empty()) {
            QApplication::exit(fail("the view " + options.view
                    + (options.view == "compare" ? " needs two planned approaches" : " needs a CT"),
                1));
            return;
        }
        try {
            window.save_screenshot(options.screenshot);
        } catch (const Error& error) {
            QApplication::exit(fail(error.where() + ": " + error.what(), 1));
            return;
        }
        QApplication::exit(window.error_line().empty() ? 0 : fail(window.error_line(), 1));
    });
    timer.start(kPollMs);
}

/// Measures the window and prints the figures. @returns the exit code
int run_benchmark(MainWindow& window, bool plan)
{
    try {
        std::fputs(to_json(measure_window(window, plan), window).c_str(), stdout);
        return 0;
    } catch (const Error& error) {
        return fail(error.what(), 1);
    }
}

/// Waits until the tissue is ready and has been felt for a while, saves the window and quits.
void take_screenshot(PalpationWindow& window, QTimer& timer, const std::string& file)
{
    constexpr int kPollMs = 50;
    constexpr double kFelt = 2.0; // some heartbeats
    QObject::connect(&timer, &QTimer::timeout, &window, [&window, &timer, file] {
        const bool failed = window.snapshot().phase == planner::PalpationSnapshot::Phase::failed;
        if (!failed && (!window.idle() || window.frame().servo.time_s < kFelt))
            return;
        timer.stop();
        if (failed)
            return QApplication::exit(fail(window.error_line(), 1));
        try {
            window.save_screenshot(file);
        } catch (const Error& error) {
            return QApplication::exit(fail(error.where() + ": " + error.what(), 1));
        }
        QApplication::exit(window.error_line().empty() ? 0 : fail(window.error_line(), 1));
    });
    timer.start(kPollMs);
}

/// Ends the process if its threads do not end soon after the last window was closed. A step of a plan, such as a
/// factorisation, cannot be interrupted. Files are whole all the same, because each is written aside and then renamed.
void end_soon(int exit_code)
{
    static constexpr auto kPatience = std::chrono::seconds(4);
    std::thread([exit_code] {
        std::this_thread::sleep_for(kPatience);
        std::_Exit(exit_code);
    }).detach();
}

/// Whether a person uses the window. A picture of the window and its speed do not depend on where it last was.
bool for_a_person(const Options& options) { return options.screenshot.empty() && !options.benchmark; }

/// Sets the language of the windows, and that of the dialogs that Qt brings along.
void speak(QApplication& application, const Options& options)
{
    const QString wanted = !options.language.empty() ? QString::fromStdString(options.language)
        : for_a_person(options)                      ? preferred_language()
                                                     : QString("en");
    try {
        set_language(wanted);
    } catch (const Error& error) { // English needs no file
        std::fprintf(stderr, "retractor-workstation: %s: %s\n", error.where().c_str(), error.what());
    }
    auto* const dialogs = new QTranslator(&application);
    if (dialogs->load("qtbase_" + language(), QLibraryInfo::location(QLibraryInfo::TranslationsPath)))
        QApplication::installTranslator(dialogs);
}

/// Runs the application until its last window is closed, and keeps the window's place. @returns the exit code
int run_window(const QWidget& window, const QString& name, const Options& options)
{
    const int exit_code = QApplication::exec();
    if (for_a_person(options))
        keep_place(window, name);
    end_soon(exit_code);
    return exit_code;
}

/// A new window for palpation, which is deleted when it is closed.
PalpationWindow& new_palpation()
{
    auto* window = new PalpationWindow(planner::PalpationBackend {});
    window->setAttribute(Qt::WA_DeleteOnClose);
    window->show();
    return *window;
}

int run_palpation(planner::Palpable palpable, const std::optional<ShownHands>& hands, const Options& options)
{
    PalpationWindow window(planner::PalpationBackend {});
    if (hands)
        window.show_hands(*hands);
    if (for_a_person(options))
        restore_place(window, "palpation", window.size());
    window.show();
    window.open(std::move(palpable.scene), { .model = options.model }, std::move(palpable.notes));
    QTimer screenshot_timer;
    if (!options.screenshot.empty())
        take_screenshot(window, screenshot_timer, options.screenshot);
    return run_window(window, "palpation", options);
}

int run_planning(std::optional<planner::Case> planned_case, const Options& options)
{
    MainWindow window([](const planner::Case& opened) { return make_planning_backend(opened, picture_language()); });
    window.on_palpation_scene = [](const std::filesystem::path& file) { new_palpation().open_file(file); };
    window.on_palpable
        = [](planner::Palpable made) { new_palpation().open(std::move(made.scene), {}, std::move(made.notes)); };
    window.on_palpable_wound = [](ShownWound wound) { new_palpation().open_through(std::move(wound)); };
    if (for_a_person(options)) {
        restore_place(window, "planning", window.size());
        window.remember_cases();
    }
    window.show();
    if (planned_case) {
        window.open(std::move(*planned_case));
        if (!options.approach.empty())
            window.select(options.approach);
        window.set_view(*view_from_string(options.view));
        window.set_wall_look(wall_look_of(options.wall));
        if (options.before)
            window.set_opened(false);
        if (options.benchmark)
            return run_benchmark(window, options.plan);
        if (options.plan || (!options.screenshot.empty() && !options.before))
            window.plan_selected();
    }
    QTimer screenshot_timer;
    if (!options.screenshot.empty())
        take_screenshot(window, screenshot_timer, options);
    return run_window(window, "planning", options);
}

/// The input of the program.
struct Given {
    std::optional<planner::Case> planned_case;
    std::optional<planner::Palpable> palpable;
    std::optional<ShownHands> hands;
};

/// @throws InputError, IoError when the input cannot be shown
Given read(const Options& options)
{
    Given given;
    if (options.palpate) {
        if (options.structure.empty())
            given.palpable = planner::Palpable { datasets::read_palpation_scene(options.case_file), {} };
        else {
            planner::Patient patient(planner::read_case(options.case_file));
            given.palpable = planner::make_palpable(patient, { .structure = { options.structure } });
        }
        if (!options.hand.empty())
            given.hands
                = ShownHands { haptics::read_hand(options.hand, false), haptics::read_hand(options.hand, true) };
        return given;
    }
    if (!options.case_file.empty())
        given.planned_case = planner::read_case(options.case_file);
    if (!options.approach.empty())
        planner::find_approach(*given.planned_case, options.approach);
    if (!options.screenshot.empty() && !options.before && given.planned_case && given.planned_case->approaches.empty())
        throw InputError("the case has no approach to plan", options.case_file);
    return given;
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    if (const auto exit_code = parse(argc, argv, options))
        return *exit_code;
    Given given;
    try {
        given = read(options);
    } catch (const Error& error) {
        // An error in a case has a JSON pointer.
        const bool names_its_place = options.palpate && !error.where().starts_with('/');
        return fail(to_string(names_its_place ? Failure { error.what(), error.where() }
                                              : case_failure(options.case_file, error)),
            2);
    } catch (const std::exception& error) {
        return fail(options.case_file + ": " + error.what(), 2);
    }
    if (!has_display())
        return fail("there is no display: set DISPLAY, or make pictures with \"retractor render\"", 1);

    QSurfaceFormat::setDefaultFormat(PictureView::defaultFormat());
    QApplication application(argc, argv);
    // Qt takes over the user's number format. The C library must keep its own format, or numbers in files would change.
    std::setlocale(LC_NUMERIC, "C");
    apply_theme(application);
    speak(application, options);
    return given.palpable ? run_palpation(std::move(*given.palpable), given.hands, options)
                          : run_planning(std::move(given.planned_case), options);
}
