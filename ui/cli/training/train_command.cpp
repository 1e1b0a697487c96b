#include "ui/cli/commands.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "datasets/phantoms/palpation_scene_file.h"
#include "haptics/training/trial_store.h"
#include "mesh/base/assert.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/command.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/palpation/palpate_run.h"
#include "ui/cli/training/train_report.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <iostream>
#include <memory>
#include <random>

namespace retractor::ui::cli {

namespace {

    struct TrainOptions {
        std::string store = "trials.sqlite", out, person, date, instruction = "haptic";
        std::string name;
        double modulus_MPa = 0.0, poissons_ratio = 0.48;
        std::string scene, device;
        PressPlan plan;
        int models = 20, study = 1;
        std::uint64_t seed = 0;
        std::vector<std::string> answers; ///< person:authenticity,ease,stability
    };

    std::string today()
    {
        const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
        std::tm parts {};
        localtime_r(&now, &parts);
        std::array<char, 16> text {};
        std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
        return text.data();
    }

    std::string date_of(const TrainOptions& options) { return options.date.empty() ? today() : options.date; }

    Outcome keep(const TrainOptions& options, const Job&)
    {
        haptics::TrialStore store(options.store);
        store.keep({ options.name, options.person, date_of(options), options.modulus_MPa, options.poissons_ratio });
        Outcome outcome;
        outcome.document = { { "name", options.name }, { "youngs_modulus_MPa", options.modulus_MPa },
            { "poissons_ratio", options.poissons_ratio }, { "expert", options.person }, { "store", options.store } };
        outcome.text = options.name + ": " + formatted("%.3g MPa", options.modulus_MPa)
            + formatted(", nu %.2f", options.poissons_ratio) + ", saved in " + options.store + "\n";
        return outcome;
    }

    Outcome list(const TrainOptions& options, const Job&)
    {
        const haptics::TrialStore store(options.store);
        Outcome outcome;
        outcome.document = { { "elasticities", Json::array() } };
        for (const haptics::NamedElasticity& e : store.elasticities()) {
            outcome.document["elasticities"].push_back({ { "name", e.name }, { "youngs_modulus_MPa", e.modulus_MPa },
                { "poissons_ratio", e.poissons_ratio }, { "expert", e.expert }, { "date", e.date } });
            outcome.text
                += e.name + ": " + formatted("%.3g MPa", e.modulus_MPa) + " (" + e.expert + ", " + e.date + ")\n";
        }
        if (outcome.text.empty())
            outcome.text = "No elasticity is saved in " + options.store + "\n";
        return outcome;
    }

    /// A vessel that a person feels at one elasticity after the other, without seeing its response.
    class FeltModels {
    public:
        FeltModels(const TrainOptions& options, std::vector<double> offered, const Job& job)
            : options_(options)
            , offered_(std::move(offered))
            , job_(job)
        {
            if (options.device.empty())
                return;
            if (options.scene.empty()) {
                datasets::AortaParameters tube;
                tube.shape = datasets::AortaParameters::Shape::tube;
                tube.region.length_mm = 0.0; // one elasticity
                scene_ = datasets::make_aorta_phantom(tube);
            } else {
                scene_ = datasets::read_palpation_scene(options.scene);
            }
            if (scene_.sites.empty())
                throw InputError("has no site to press", scene_.name);
        }

        /// @param place number of the model, from 1
        void feel(int place)
        {
            if (options_.device.empty()) {
                std::cerr << "The operator sets up these models. To feel the models here, add --device (simulated, "
                             "touch, udp:PORT).\n";
                return;
            }
            RETRACTOR_ASSERT(place >= 1 && static_cast<std::size_t>(place) <= offered_.size());
            RETRACTOR_ASSERT(!scene_.sites.empty());
            datasets::ElasticModel& body = scene_.body;
            body.youngs_modulus.assign(body.youngs_modulus.size(), offered_[static_cast<std::size_t>(place - 1)]);
            const planner::TissueChoice choice { .radius_mm = options_.plan.radius_mm };
            const planner::ChosenTissue tissue = make_tissue(scene_, choice, job_);
            std::cerr << "Model " << place << " is now under the finger.\n";
            const PressLog log = run_press({ "model " + std::to_string(place), { scene_.sites[0] } }, *tissue.response,
                { options_.device }, options_.plan, nullptr, 1.0, job_);
            std::cerr << (log.fault.empty() ? std::string("The model is removed again.")
                                            : "The forces were switched off: " + log.fault)
                      << '\n';
            touched_.push_back(place);
        }
        const std::vector<int>& touched() const { return touched_; }

    private:
        const TrainOptions& options_;
        std::vector<double> offered_; ///< offered elasticities in the order of the test, MPa
        const Job& job_;
        datasets::PalpationScene scene_;
        std::vector<int> touched_;
    };

    /// Asks for a model's number in the offered order, from 1: "7". "feel 7" first lets the person feel the model.
    int asked_place(const std::string& question, int count, FeltModels& models)
    {
        for (;;) {
            std::cerr << question << " (1 to " << count << ", or feel 1 to feel " << count << "): " << std::flush;
            std::string line;
            if (!std::getline(std::cin, line))
                throw InputError("the test ended before both tissues were chosen; no choice is saved");
            const bool feels = line.starts_with("feel ");
            const std::string word = feels ? line.substr(5) : line;
            char* end = nullptr;
            const long place = std::strtol(word.c_str(), &end, 10);
            const bool known = end != word.c_str() && *end == '\0' && place >= 1 && place <= count;
            if (known && !feels)
                return static_cast<int>(place);
            if (known)
                models.feel(static_cast<int>(place));
            else
                std::cerr << "Please give a number from 1 to " << count << ".\n";
        }
    }

    /// The test stage offers models in a random order, by number only. The learning stage then shows the correct
    /// answers.
    Outcome test(const TrainOptions& options, const Job& job)
    {
        haptics::TrialStore store(options.store);
        if (options.person.empty())
            throw InputError("name the trainee", "--trainee");
        const haptics::Instruction instruction = haptics::instruction_of(options.instruction);
        const std::vector<double> models = haptics::trial_models(options.models);
        if (models.back() < haptics::kScleroticMPa - 1e-9)
            std::cerr << "The stiffest of these models has " << models.back()
                      << " MPa, so the test asks only for normal tissue.\n";
        std::uint64_t seed = options.seed;
        if (seed == 0)
            seed = (static_cast<std::uint64_t>(std::random_device {}()) << 32) | std::random_device {}();
        const std::vector<int> order = haptics::trial_order(options.models, seed);
        RETRACTOR_ASSERT(order.size() == models.size());
        const int session = store.next_session(options.person);
        // The operator's list of models, which the trainee must not see.
        if (!options.out.empty()) {
            std::string sheet = "offered_as,youngs_modulus_MPa\n";
            for (std::size_t i = 0; i < order.size(); ++i)
                sheet += std::to_string(i + 1) + "," + formatted("%.1f", models[static_cast<std::size_t>(order[i])])
                    + "\n";
            write_file_atomically(options.out, sheet);
            std::cerr << "The order is in " << options.out << ", for the operator who sets up the models.\n";
        }
        std::cerr << "Session " << session << " of " << options.person << ": feel models 1 to " << options.models
                  << " as often as you like.\n";
        std::vector<double> offered;
        for (const int model : order)
            offered.push_back(models[static_cast<std::size_t>(model)]);
        FeltModels felt(options, offered, job);
        std::vector<haptics::ElasticityTrial> trials;
        Outcome outcome;
        outcome.document = { { "trainee", options.person }, { "session", session },
            { "order_seed", std::to_string(seed) }, { "choices", Json::array() } };
        for (const haptics::Tissue tissue : { haptics::Tissue::normal, haptics::Tissue::sclerotic }) {
            const double right = tissue == haptics::Tissue::normal ? haptics::kNormalMPa : haptics::kScleroticMPa;
            if (right > models.back() + 1e-9)
                continue;
            const int place
                = asked_place("Which model feels " + std::string(to_string(tissue)) + "?", options.models, felt);
            const double chosen = models[static_cast<std::size_t>(order[static_cast<std::size_t>(place - 1)])];
            trials.push_back({ options.person, instruction, session, date_of(options), tissue, chosen, right, seed });
        }
        store.add(trials);
        outcome.document["felt"] = felt.touched();
        for (const haptics::ElasticityTrial& trial : trials) { // the learning stage
            const auto at = std::find_if(order.begin(), order.end(),
                [&](int model) { return std::abs(models[static_cast<std::size_t>(model)] - trial.right_MPa) < 1e-9; });
            const auto shown = at - order.begin() + 1;
            outcome.document["choices"].push_back({ { "tissue", to_string(trial.tissue) },
                { "chosen_MPa", trial.chosen_MPa }, { "right_MPa", trial.right_MPa }, { "right_was_model", shown } });
            outcome.text += std::string(to_string(trial.tissue)) + ": you chose "
                + formatted("%.1f MPa", trial.chosen_MPa) + "; the correct answer is "
                + formatted("%.1f MPa", trial.right_MPa) + ", model " + std::to_string(shown)
                + ". Feel this model again\n";
        }
        return outcome;
    }

    Outcome simulate(const TrainOptions& options, const Job&)
    {
        haptics::TrialStore store(options.store);
        const std::uint64_t seed = options.seed == 0 ? 1 : options.seed;
        std::vector<haptics::ElasticityTrial> trials = options.study == 1 ? haptics::simulate_modelling_study(seed)
            : options.study == 2                                          ? haptics::simulate_recognition_study(seed)
                                                                          : haptics::simulate_learning_study(seed);
        // The prefix tells simulated people from real ones, and the people of one study from those of another.
        const std::string prefix = "simulated-" + std::to_string(options.study) + "-" + std::to_string(seed) + "-";
        for (const haptics::ElasticityTrial& kept : store.trials())
            if (kept.trainee.starts_with(prefix))
                throw InputError("this study is in the file already; give another --seed", options.store);
        for (haptics::ElasticityTrial& trial : trials)
            trial.trainee = prefix + trial.trainee;
        store.add(trials);
        Outcome outcome;
        outcome.document = { { "study", options.study }, { "trials", trials.size() }, { "store", options.store } };
        outcome.text = std::to_string(trials.size()) + " trials of simulated people, study "
            + std::to_string(options.study) + ", added to " + options.store + "\n";
        return outcome;
    }

    bool yes(const std::string& word, const std::string& where)
    {
        if (word == "yes" || word == "1")
            return true;
        if (word == "no" || word == "0")
            return false;
        throw InputError("an answer must be yes or no, got " + word, where);
    }

    Outcome questionnaire(const TrainOptions& options, const Job&)
    {
        haptics::TrialStore store(options.store);
        for (const std::string& text : options.answers) {
            const std::size_t colon = text.find(':');
            const std::vector<std::string> words
                = colon == std::string::npos ? std::vector<std::string>() : split(text.substr(colon + 1), ',');
            if (words.size() != 3)
                throw InputError("write answers as PERSON:AUTHENTIC,EASY,STABLE, got " + text, "--answer");
            store.answer({ text.substr(0, colon), yes(words[0], text), yes(words[1], text), yes(words[2], text) });
        }
        const haptics::QualityVerdict verdict = haptics::judge(store.answers());
        Outcome outcome;
        outcome.document = { { "persons", verdict.persons }, { "authenticity", verdict.authenticity },
            { "ease", verdict.ease }, { "stability", verdict.stability }, { "passes", verdict.passes() } };
        outcome.text = std::to_string(verdict.persons) + " persons: authentic " + std::to_string(verdict.authenticity)
            + ", easy " + std::to_string(verdict.ease) + ", stable " + std::to_string(verdict.stability)
            + (verdict.passes() ? ": passes\n" : ": does not pass (each question needs 8 of 10 positive answers)\n");
        return outcome;
    }

} // namespace

void add_train_command(Commands& commands)
{
    CLI::App* train = commands.app.add_subcommand(
        "train", "Teach elasticity by touch with named models and blind tests, and report the statistics");
    train->require_subcommand(1);
    train->footer("Example: retractor train simulate --study 3 --store t.sqlite && retractor train report --store "
                  "t.sqlite --out D");
    auto options = std::make_shared<TrainOptions>();
    const auto add = [&](const char* name, const char* help, const char* example, auto run) {
        CLI::App* command = train->add_subcommand(name, help);
        command->footer(std::string("Example: retractor train ") + example);
        command->add_option("--store", options->store, "SQLite file of all sessions; a missing file is made")
            ->capture_default_str();
        commands.on(command, [options, run](const Job& job) { return run(*options, job); });
        return command;
    };
    CLI::App* expert = add("expert", "Save an elasticity that feels right to an expert",
        "expert --name \"normal aorta\" --modulus 1.0 --expert \"Dr A\"", keep);
    expert->add_option("--name", options->name, "Name of the elasticity")->required();
    expert->add_option("--modulus", options->modulus_MPa, "Young's modulus, MPa")->required();
    expert->add_option("--ratio", options->poissons_ratio, "Poisson's ratio")->capture_default_str();
    expert->add_option("--expert", options->person, "Name of the expert");
    expert->add_option("--date", options->date, "YYYY-MM-DD (default: today)");
    add("list", "List the saved elasticities", "list", list);
    CLI::App* trial = add("test",
        "Test a trainee with hidden models, then show the correct answers. Standard input takes the model to feel "
        "(feel 3) and the choice (3)",
        "test --trainee \"student 7\" --instruction haptic --order order.csv", test);
    trial->add_option("--trainee", options->person, "Name of the trainee")->required();
    trial
        ->add_option(
            "--instruction", options->instruction, "Instruction of the trainee before the test: none, verbal or haptic")
        ->check(CLI::IsMember({ "none", "verbal", "haptic" }))
        ->capture_default_str();
    trial->add_option("--models", options->models, "Number of models, 0.2 MPa apart")
        ->check(CLI::Range(2, 200))
        ->capture_default_str();
    trial->add_option(
        "--order", options->out, "CSV file for the operator that lists the model behind each offered number");
    trial->add_option(
        "--device", options->device, std::string("Device with which the trainee feels the models: ") + kDeviceHelp);
    trial->add_option("--scene", options->scene,
        "Palpation scene that takes the elasticity of each model (default: a straight vessel)");
    trial->add_option("--seconds", options->plan.seconds, "Time for which the trainee feels a model, s")
        ->check(in_range(0.1, 3600.0))
        ->capture_default_str();
    trial->add_option("--depth", options->plan.depth_mm, "Depth to which a simulated hand presses, mm")
        ->check(in_range(0.01, 10.0))
        ->capture_default_str();
    trial->add_option("--seed", options->seed, "Seed of the order (default: random)");
    trial->add_option("--date", options->date, "YYYY-MM-DD (default: today)");
    CLI::App* people = add("simulate",
        "Add one of three published studies (Nakao et al. 2006) with simulated people of known sensitivity",
        "simulate --study 2 --store t.sqlite", simulate);
    people
        ->add_option("--study", options->study,
            "1: eight surgeons set elasticities; 2: 18 students after three kinds of instruction; 3: ten students in "
            "seven sessions")
        ->check(CLI::Range(1, 3))
        ->capture_default_str();
    people->add_option("--seed", options->seed, "Seed of the simulated people");
    CLI::App* results = add("report",
        "Report box plots, learning curves, F-tests of spreads and t-tests of deviations, with CSV files",
        "report --store t.sqlite --out D",
        [](const TrainOptions& given, const Job& job) { return train_report(given.store, given.out, job); });
    results->add_option("--out", options->out, "Folder for trials.csv, trials.json and the charts");
    CLI::App* quality = add("questionnaire",
        "Record the answers of ten persons on haptic quality; an aspect passes with 8 positive answers",
        "questionnaire --answer \"person 1:yes,yes,no\"", questionnaire);
    quality->add_option("--answer", options->answers, "PERSON:AUTHENTIC,EASY,STABLE, each yes or no (repeatable)");
}

} // namespace retractor::ui::cli
