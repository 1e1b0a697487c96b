#include "ui/cli/train_command.h"

#include "haptics/trial_statistics.h"
#include "haptics/trial_store.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "ui/cli/arguments.h"
#include "ui/cli/command.h"
#include "ui/cli/field_files.h"
#include "ui/cli/trial_charts.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>
#include <random>

namespace retractor::cli {

namespace {

    struct TrainOptions {
        std::string store = "trials.sqlite", out, person, date, instruction = "haptic";
        std::string name;
        double modulus_MPa = 0.0, poissons_ratio = 0.48;
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

    std::string number(const char* format, double value)
    {
        std::array<char, 64> text {};
        std::snprintf(text.data(), text.size(), format, value);
        return text.data();
    }

    Outcome keep(const TrainOptions& options, const Job&)
    {
        TrialStore store(options.store);
        store.keep({ options.name, options.person, date_of(options), options.modulus_MPa, options.poissons_ratio });
        Outcome outcome;
        outcome.document = { { "name", options.name }, { "youngs_modulus_MPa", options.modulus_MPa },
            { "poissons_ratio", options.poissons_ratio }, { "expert", options.person }, { "store", options.store } };
        outcome.text = options.name + ": " + number("%.3g MPa", options.modulus_MPa)
            + number(", nu %.2f", options.poissons_ratio) + ", kept in " + options.store + "\n";
        return outcome;
    }

    Outcome list(const TrainOptions& options, const Job&)
    {
        const TrialStore store(options.store);
        Outcome outcome;
        outcome.document = { { "elasticities", Json::array() } };
        for (const NamedElasticity& e : store.elasticities()) {
            outcome.document["elasticities"].push_back({ { "name", e.name }, { "youngs_modulus_MPa", e.modulus_MPa },
                { "poissons_ratio", e.poissons_ratio }, { "expert", e.expert }, { "date", e.date } });
            outcome.text += e.name + ": " + number("%.3g MPa", e.modulus_MPa) + " (" + e.expert + ", " + e.date + ")\n";
        }
        if (outcome.text.empty())
            outcome.text = "No elasticity is kept in " + options.store + "\n";
        return outcome;
    }

    /// "7": the model's letter as offered, from 1.
    int asked_place(const std::string& question, int count)
    {
        for (;;) {
            std::cerr << question << " (1 to " << count << "): " << std::flush;
            std::string line;
            if (!std::getline(std::cin, line))
                throw InputError("the test ended before both tissues were chosen; nothing is kept");
            char* end = nullptr;
            const long place = std::strtol(line.c_str(), &end, 10);
            if (end != line.c_str() && *end == '\0' && place >= 1 && place <= count)
                return static_cast<int>(place);
            std::cerr << "Please give a number from 1 to " << count << ".\n";
        }
    }

    /// Test stage: models in a random order, by number alone; then the learning stage: which ones were right.
    Outcome test(const TrainOptions& options, const Job&)
    {
        TrialStore store(options.store);
        if (options.person.empty())
            throw InputError("who is tested?", "--trainee");
        const Instruction instruction = instruction_of(options.instruction);
        const std::vector<double> models = trial_models(options.models);
        if (models.back() < kScleroticMPa - 1e-9)
            std::cerr << "These models end at " << models.back() << " MPa: only normal tissue is asked for.\n";
        std::uint64_t seed = options.seed;
        if (seed == 0)
            seed = (static_cast<std::uint64_t>(std::random_device {}()) << 32) | std::random_device {}();
        const std::vector<int> order = trial_order(options.models, seed);
        const int session = store.next_session(options.person);
        // What the operator sets up, model by model, where the trainee does not see it.
        if (!options.out.empty()) {
            std::string sheet = "offered_as,youngs_modulus_MPa\n";
            for (std::size_t i = 0; i < order.size(); ++i)
                sheet
                    += std::to_string(i + 1) + "," + number("%.1f", models[static_cast<std::size_t>(order[i])]) + "\n";
            write_file_atomically(options.out, sheet);
            std::cerr << "The order is in " << options.out << ", for whoever sets up the models.\n";
        }
        std::cerr << "Session " << session << " of " << options.person << ": feel models 1 to " << options.models
                  << " as often as you like.\n";
        std::vector<ElasticityTrial> trials;
        Outcome outcome;
        outcome.document = { { "trainee", options.person }, { "session", session },
            { "order_seed", std::to_string(seed) }, { "choices", Json::array() } };
        for (const Tissue tissue : { Tissue::normal, Tissue::sclerotic }) {
            const double right = tissue == Tissue::normal ? kNormalMPa : kScleroticMPa;
            if (right > models.back() + 1e-9)
                continue;
            const int place = asked_place("Which model feels " + std::string(to_string(tissue)) + "?", options.models);
            const double chosen = models[static_cast<std::size_t>(order[static_cast<std::size_t>(place - 1)])];
            trials.push_back({ options.person, instruction, session, date_of(options), tissue, chosen, right, seed });
        }
        store.add(trials);
        for (const ElasticityTrial& trial : trials) { // the learning stage
            const auto at = std::find_if(order.begin(), order.end(),
                [&](int model) { return std::abs(models[static_cast<std::size_t>(model)] - trial.right_MPa) < 1e-9; });
            const auto shown = at - order.begin() + 1;
            outcome.document["choices"].push_back({ { "tissue", to_string(trial.tissue) },
                { "chosen_MPa", trial.chosen_MPa }, { "right_MPa", trial.right_MPa }, { "right_was_model", shown } });
            outcome.text += std::string(to_string(trial.tissue)) + ": you chose " + number("%.1f MPa", trial.chosen_MPa)
                + "; right is " + number("%.1f MPa", trial.right_MPa) + ", model " + std::to_string(shown)
                + ": feel it again\n";
        }
        return outcome;
    }

    Outcome simulate(const TrainOptions& options, const Job&)
    {
        TrialStore store(options.store);
        const std::uint64_t seed = options.seed == 0 ? 1 : options.seed;
        std::vector<ElasticityTrial> trials = options.study == 1 ? simulate_modelling_study(seed)
            : options.study == 2                                 ? simulate_recognition_study(seed)
                                                                 : simulate_learning_study(seed);
        // Nobody may take them for people, nor the people of one study for those of another.
        const std::string prefix = "simulated-" + std::to_string(options.study) + "-" + std::to_string(seed) + "-";
        for (const ElasticityTrial& kept : store.trials())
            if (kept.trainee.starts_with(prefix))
                throw InputError("this study is in the file already; give another --seed", options.store);
        for (ElasticityTrial& trial : trials)
            trial.trainee = prefix + trial.trainee;
        store.add(trials);
        Outcome outcome;
        outcome.document = { { "study", options.study }, { "trials", trials.size() }, { "store", options.store } };
        outcome.text = std::to_string(trials.size()) + " trials of simulated people, study "
            + std::to_string(options.study) + ", added to " + options.store + "\n";
        return outcome;
    }

    std::vector<double> chosen(const std::vector<ElasticityTrial>& trials, auto which)
    {
        std::vector<double> values;
        for (const ElasticityTrial& trial : trials)
            if (which(trial))
                values.push_back(trial.chosen_MPa);
        return values;
    }

    Json box_document(const BoxNumbers& box)
    {
        return { { "count", box.count }, { "low", box.low }, { "lower_quartile", box.lower_quartile },
            { "median", box.median }, { "upper_quartile", box.upper_quartile }, { "high", box.high } };
    }

    /// A test that cannot be made (one person, no spread) is left out with its reason.
    template <class Make> Json test_document(Make make)
    {
        try {
            return make();
        } catch (const InputError& error) {
            return { { "not_made", error.what() } };
        }
    }

    Json spread_test(const std::vector<double>& a, const std::vector<double>& b)
    {
        return test_document([&]() -> Json {
            const FTest test = f_test(a, b);
            return { { "F", test.F }, { "p", test.p }, { "freedom", { test.freedom_a, test.freedom_b } } };
        });
    }

    /// Of the same people in two sessions; whoever has not exactly one trial in each is left out and counted.
    Json learning_test(const std::vector<ElasticityTrial>& trials, Tissue tissue, int from, int to)
    {
        std::map<std::string, std::array<std::vector<double>, 2>> deviations;
        for (const ElasticityTrial& trial : trials)
            if (trial.tissue == tissue && (trial.session == from || trial.session == to))
                deviations[trial.trainee][trial.session == from ? 0 : 1].push_back(
                    std::abs(trial.chosen_MPa - trial.right_MPa));
        std::vector<double> before, after;
        for (const auto& [trainee, of] : deviations)
            if (of[0].size() == 1 && of[1].size() == 1) {
                before.push_back(of[0].front());
                after.push_back(of[1].front());
            }
        const std::size_t left_out = deviations.size() - before.size();
        return test_document([&]() -> Json {
            const TTest test = paired_t_test(before, after);
            return { { "sessions", { from, to } }, { "people", before.size() }, { "left_out", left_out },
                { "t", test.t }, { "p", test.p }, { "freedom", test.freedom },
                { "deviation_falls_by_MPa", test.difference } };
        });
    }

    Outcome report(const TrainOptions& options, const Job& job)
    {
        const TrialStore store(options.store);
        const std::vector<ElasticityTrial> trials = store.trials();
        if (trials.empty())
            throw InputError("there are no trials yet", options.store);
        Outcome outcome;
        std::vector<BoxSeries> by_instruction, by_session;
        Json instructions = Json::array(), sessions = Json::array(), spreads = Json::array(), learning = Json::array();
        int last = 1;
        for (const ElasticityTrial& trial : trials)
            last = std::max(last, trial.session);
        for (const Tissue tissue : { Tissue::normal, Tissue::sclerotic }) {
            const double right = tissue == Tissue::normal ? kNormalMPa : kScleroticMPa;
            BoxSeries conditions { .title = std::string(to_string(tissue)) + " by instruction, first session",
                .target = right,
                .boxes = {},
                .labels = {} };
            std::array<std::vector<double>, 3> of;
            for (const Instruction one : { Instruction::none, Instruction::verbal, Instruction::haptic }) {
                auto& values = of[static_cast<std::size_t>(one)];
                values = chosen(trials,
                    [&](const auto& t) { return t.tissue == tissue && t.instruction == one && t.session == 1; });
                if (values.empty())
                    continue;
                conditions.boxes.push_back(box_numbers(values));
                conditions.labels.push_back(std::string(to_string(one)));
                instructions.push_back({ { "tissue", to_string(tissue) }, { "instruction", to_string(one) },
                    { "box_MPa", box_document(conditions.boxes.back()) } });
            }
            for (const auto& [a, b] : { std::pair { 0, 1 }, { 0, 2 }, { 1, 2 } })
                if (!of[static_cast<std::size_t>(a)].empty() && !of[static_cast<std::size_t>(b)].empty())
                    spreads.push_back({ { "tissue", to_string(tissue) },
                        { "between",
                            { to_string(static_cast<Instruction>(a)), to_string(static_cast<Instruction>(b)) } },
                        { "F_test", spread_test(of[static_cast<std::size_t>(a)], of[static_cast<std::size_t>(b)]) } });
            if (!conditions.boxes.empty())
                by_instruction.push_back(conditions);
            BoxSeries curve {
                .title = std::string(to_string(tissue)) + " by session", .target = right, .boxes = {}, .labels = {}
            };
            for (int session = 1; session <= last; ++session) {
                const auto values
                    = chosen(trials, [&](const auto& t) { return t.tissue == tissue && t.session == session; });
                if (values.empty())
                    continue;
                curve.boxes.push_back(box_numbers(values));
                curve.labels.push_back(std::to_string(session));
                sessions.push_back({ { "tissue", to_string(tissue) }, { "session", session },
                    { "box_MPa", box_document(curve.boxes.back()) } });
                if (session > 1)
                    learning.push_back({ { "tissue", to_string(tissue) },
                        { "t_test_of_deviations", learning_test(trials, tissue, 1, session) } });
            }
            if (!curve.boxes.empty())
                by_session.push_back(curve);
        }
        const std::vector<QualityAnswer> answers = store.answers();
        const QualityVerdict verdict = judge(answers);
        outcome.document = { { "store", options.store }, { "trials", trials.size() },
            { "by_instruction", instructions }, { "spread_tests", spreads }, { "by_session", sessions },
            { "learning_tests", learning },
            { "questionnaire",
                { { "persons", verdict.persons }, { "authenticity", verdict.authenticity }, { "ease", verdict.ease },
                    { "stability", verdict.stability }, { "passes", verdict.passes() } } } };
        const auto line = [&](const Json& box) {
            return number("%.2f", box["median"].get<double>()) + " MPa (quartiles "
                + number("%.2f", box["lower_quartile"].get<double>()) + " to "
                + number("%.2f", box["upper_quartile"].get<double>()) + ", " + std::to_string(box["count"].get<int>())
                + " choices)\n";
        };
        for (const Json& row : instructions)
            outcome.text += row["tissue"].get<std::string>() + ", instruction " + row["instruction"].get<std::string>()
                + ": " + line(row["box_MPa"]);
        for (const Json& row : spreads)
            if (row["F_test"].contains("p"))
                outcome.text += "  spreads, " + row["between"][0].get<std::string>() + " and "
                    + row["between"][1].get<std::string>() + ": F " + number("%.2f", row["F_test"]["F"].get<double>())
                    + number(", p %.2g\n", row["F_test"]["p"].get<double>());
        for (const Json& row : sessions)
            outcome.text += row["tissue"].get<std::string>() + ", session " + std::to_string(row["session"].get<int>())
                + ": " + line(row["box_MPa"]);
        for (const Json& row : learning)
            if (row["t_test_of_deviations"].contains("p"))
                outcome.text += "  " + row["tissue"].get<std::string>() + ", deviation in session 1 against session "
                    + std::to_string(row["t_test_of_deviations"]["sessions"][1].get<int>()) + ": t "
                    + number("%.2f", row["t_test_of_deviations"]["t"].get<double>())
                    + number(", p %.2g\n", row["t_test_of_deviations"]["p"].get<double>());
        if (verdict.persons > 0)
            outcome.text += "questionnaire, " + std::to_string(verdict.persons) + " persons: authentic "
                + std::to_string(verdict.authenticity) + ", easy " + std::to_string(verdict.ease) + ", stable "
                + std::to_string(verdict.stability)
                + (verdict.passes() ? ": passes\n" : ": does not pass (8 of 10 are needed)\n");
        if (!options.out.empty()) {
            const std::filesystem::path folder = options.out;
            make_folder(folder);
            write_file_atomically(folder / "trials.csv", trials_csv(trials));
            write_file_atomically(folder / "trials.json", outcome.document.dump(2) + "\n");
            if (!by_instruction.empty())
                write_box_chart(folder / "instruction.png", by_instruction, "instruction", job);
            if (!by_session.empty())
                write_box_chart(folder / "learning.png", by_session, "session", job);
            outcome.text
                += "Written: " + (folder / "trials.csv").string() + ", trials.json, instruction.png, learning.png\n";
        }
        return outcome;
    }

    bool yes(const std::string& word, const std::string& where)
    {
        if (word == "yes" || word == "1")
            return true;
        if (word == "no" || word == "0")
            return false;
        throw InputError("an answer is yes or no, got " + word, where);
    }

    Outcome questionnaire(const TrainOptions& options, const Job&)
    {
        TrialStore store(options.store);
        for (const std::string& text : options.answers) {
            const std::size_t colon = text.find(':');
            const std::vector<std::string> words
                = colon == std::string::npos ? std::vector<std::string>() : split(text.substr(colon + 1), ',');
            if (words.size() != 3)
                throw InputError("answers are PERSON:AUTHENTIC,EASY,STABLE, got " + text, "--answer");
            store.answer({ text.substr(0, colon), yes(words[0], text), yes(words[1], text), yes(words[2], text) });
        }
        const QualityVerdict verdict = judge(store.answers());
        Outcome outcome;
        outcome.document = { { "persons", verdict.persons }, { "authenticity", verdict.authenticity },
            { "ease", verdict.ease }, { "stability", verdict.stability }, { "passes", verdict.passes() } };
        outcome.text = std::to_string(verdict.persons) + " persons: authentic " + std::to_string(verdict.authenticity)
            + ", easy " + std::to_string(verdict.ease) + ", stable " + std::to_string(verdict.stability)
            + (verdict.passes() ? ": passes\n" : ": does not pass (8 of 10 positive answers to each are needed)\n");
        return outcome;
    }

} // namespace

void add_train_command(Commands& commands)
{
    CLI::App* train = commands.app.add_subcommand(
        "train", "Teach elasticity by touch: named models, blind tests, their statistics");
    train->require_subcommand(1);
    train->footer("Example: retractor train simulate --study 3 --store t.sqlite && retractor train report --store "
                  "t.sqlite --out D");
    auto options = std::make_shared<TrainOptions>();
    const auto add = [&](const char* name, const char* help, const char* example, auto run) {
        CLI::App* command = train->add_subcommand(name, help);
        command->footer(std::string("Example: retractor train ") + example);
        command->add_option("--store", options->store, "SQLite file of all sessions; made when it is not there")
            ->capture_default_str();
        command->callback([&commands, options, run] {
            commands.run = [options, run](const Job& job) { return run(*options, job); };
        });
        return command;
    };
    CLI::App* expert = add("expert", "Keep an elasticity that feels right under a name",
        "expert --name \"normal aorta\" --modulus 1.0 --expert \"Dr A\"", keep);
    expert->add_option("--name", options->name, "Its name")->required();
    expert->add_option("--modulus", options->modulus_MPa, "Young's modulus, MPa")->required();
    expert->add_option("--ratio", options->poissons_ratio, "Poisson's ratio")->capture_default_str();
    expert->add_option("--expert", options->person, "Who says so");
    expert->add_option("--date", options->date, "YYYY-MM-DD (default: today)");
    add("list", "The elasticities that were kept", "list", list);
    CLI::App* trial
        = add("test", "A blind test, and what was right: reads the chosen models' numbers from standard input",
            "test --trainee \"student 7\" --instruction haptic --order order.csv", test);
    trial->add_option("--trainee", options->person, "Who is tested")->required();
    trial->add_option("--instruction", options->instruction, "What the trainee was told before: none, verbal or haptic")
        ->check(CLI::IsMember({ "none", "verbal", "haptic" }))
        ->capture_default_str();
    trial->add_option("--models", options->models, "How many, 0.2 MPa apart")
        ->check(CLI::Range(2, 200))
        ->capture_default_str();
    trial->add_option("--order", options->out, "CSV of which model is offered as which number, for the operator");
    trial->add_option("--seed", options->seed, "Of the order (default: random)");
    trial->add_option("--date", options->date, "YYYY-MM-DD (default: today)");
    CLI::App* people
        = add("simulate", "Add one of the source's three studies with simulated people of known sensitivity",
            "simulate --study 2 --store t.sqlite", simulate);
    people
        ->add_option("--study", options->study,
            "1: eight surgeons model; 2: 18 students by instruction; 3: ten students, seven sessions")
        ->check(CLI::Range(1, 3))
        ->capture_default_str();
    people->add_option("--seed", options->seed, "Of the people");
    CLI::App* results = add("report", "Box plots, learning curves, F-tests of spreads, t-tests of deviations, CSV",
        "report --store t.sqlite --out D", report);
    results->add_option("--out", options->out, "Folder for trials.csv, trials.json and the charts");
    CLI::App* quality = add("questionnaire", "Ten persons on haptic quality: each aspect passes at 8 of 10",
        "questionnaire --answer \"person 1:yes,yes,no\"", questionnaire);
    quality->add_option("--answer", options->answers, "PERSON:AUTHENTIC,EASY,STABLE, each yes or no (repeatable)");
}

} // namespace retractor::cli
