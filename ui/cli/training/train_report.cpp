#include "ui/cli/training/train_report.h"

#include "haptics/training/trial_statistics.h"
#include "haptics/training/trial_store.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/training/trial_charts.h"

#include <algorithm>
#include <array>
#include <map>

namespace retractor::ui::cli {

namespace {

    std::vector<double> chosen(const std::vector<haptics::ElasticityTrial>& trials, auto which)
    {
        std::vector<double> values;
        for (const haptics::ElasticityTrial& trial : trials)
            if (which(trial))
                values.push_back(trial.chosen_MPa);
        return values;
    }

    Json box_document(const haptics::BoxNumbers& box)
    {
        return { { "count", box.count }, { "low", box.low }, { "lower_quartile", box.lower_quartile },
            { "median", box.median }, { "upper_quartile", box.upper_quartile }, { "high", box.high } };
    }

    /// The document of a test, or the reason why the test is impossible (one person, no spread).
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
            const haptics::FTest test = haptics::f_test(a, b);
            return { { "F", test.F }, { "p", test.p }, { "freedom", { test.freedom_a, test.freedom_b } } };
        });
    }

    /// Compares two sessions of the same people. A person without exactly one trial in each session is left out and
    /// counted.
    Json learning_test(const std::vector<haptics::ElasticityTrial>& trials, haptics::Tissue tissue, int from, int to)
    {
        std::map<std::string, std::array<std::vector<double>, 2>> deviations;
        for (const haptics::ElasticityTrial& trial : trials)
            if (trial.tissue == tissue && (trial.session == from || trial.session == to))
                deviations[trial.trainee][trial.session == from ? 0 : 1].push_back(
                    std::abs(trial.chosen_MPa - trial.right_MPa));
        std::vector<double> before, after;
        for (const auto& [trainee, of] : deviations)
            if (of[0].size() == 1 && of[1].size() == 1) {
                before.push_back(of[0].front());
                after.push_back(of[1].front());
            }
        const std::size_t omitted = deviations.size() - before.size();
        return test_document([&]() -> Json {
            const haptics::TTest test = haptics::paired_t_test(before, after);
            return { { "sessions", { from, to } }, { "people", before.size() }, { "left_out", omitted },
                { "t", test.t }, { "p", test.p }, { "freedom", test.freedom },
                { "deviation_falls_by_MPa", test.difference } };
        });
    }

    constexpr std::array kTissues { haptics::Tissue::normal, haptics::Tissue::sclerotic };

    double right_of(haptics::Tissue tissue)
    {
        return tissue == haptics::Tissue::normal ? haptics::kNormalMPa : haptics::kScleroticMPa;
    }

    struct Findings {
        std::vector<BoxSeries> by_instruction, by_session;
        Json instructions = Json::array(), sessions = Json::array(), spreads = Json::array(), learning = Json::array();
    };

    /// Adds the first session, by the instruction that people received.
    void add_instructions(
        Findings& findings, const std::vector<haptics::ElasticityTrial>& trials, haptics::Tissue tissue)
    {
        BoxSeries boxes { .title = std::string(to_string(tissue)) + " by instruction, first session",
            .target = right_of(tissue),
            .boxes = {},
            .labels = {} };
        std::array<std::vector<double>, 3> of;
        for (const haptics::Instruction one :
            { haptics::Instruction::none, haptics::Instruction::verbal, haptics::Instruction::haptic }) {
            auto& values = of[static_cast<std::size_t>(one)];
            values = chosen(
                trials, [&](const auto& t) { return t.tissue == tissue && t.instruction == one && t.session == 1; });
            if (values.empty())
                continue;
            boxes.boxes.push_back(haptics::box_numbers(values));
            boxes.labels.push_back(std::string(to_string(one)));
            findings.instructions.push_back({ { "tissue", to_string(tissue) }, { "instruction", to_string(one) },
                { "box_MPa", box_document(boxes.boxes.back()) } });
        }
        for (const auto& [a, b] : { std::pair<std::size_t, std::size_t> { 0, 1 }, { 0, 2 }, { 1, 2 } })
            if (!of[a].empty() && !of[b].empty())
                findings.spreads.push_back({ { "tissue", to_string(tissue) },
                    { "between",
                        { to_string(static_cast<haptics::Instruction>(a)),
                            to_string(static_cast<haptics::Instruction>(b)) } },
                    { "F_test", spread_test(of[a], of[b]) } });
        if (!boxes.boxes.empty())
            findings.by_instruction.push_back(boxes);
    }

    /// Adds all trials, by session.
    void add_sessions(Findings& findings, const std::vector<haptics::ElasticityTrial>& trials, haptics::Tissue tissue)
    {
        int last = 1;
        for (const haptics::ElasticityTrial& trial : trials)
            last = std::max(last, trial.session);
        BoxSeries curve { .title = std::string(to_string(tissue)) + " by session",
            .target = right_of(tissue),
            .boxes = {},
            .labels = {} };
        for (int session = 1; session <= last; ++session) {
            const auto values
                = chosen(trials, [&](const auto& t) { return t.tissue == tissue && t.session == session; });
            if (values.empty())
                continue;
            curve.boxes.push_back(haptics::box_numbers(values));
            curve.labels.push_back(std::to_string(session));
            findings.sessions.push_back({ { "tissue", to_string(tissue) }, { "session", session },
                { "box_MPa", box_document(curve.boxes.back()) } });
            if (session > 1)
                findings.learning.push_back({ { "tissue", to_string(tissue) },
                    { "t_test_of_deviations", learning_test(trials, tissue, 1, session) } });
        }
        if (!curve.boxes.empty())
            findings.by_session.push_back(curve);
    }

    std::string line_of(const Json& box)
    {
        return formatted("%.2f", box["median"].get<double>()) + " MPa (quartiles "
            + formatted("%.2f", box["lower_quartile"].get<double>()) + " to "
            + formatted("%.2f", box["upper_quartile"].get<double>()) + ", " + std::to_string(box["count"].get<int>())
            + " choices)\n";
    }

    std::string text_of(const Findings& findings)
    {
        std::string text;
        for (const Json& row : findings.instructions)
            text += row["tissue"].get<std::string>() + ", instruction " + row["instruction"].get<std::string>() + ": "
                + line_of(row["box_MPa"]);
        for (const Json& row : findings.spreads)
            if (row["F_test"].contains("p"))
                text += "  spreads, " + row["between"][0].get<std::string>() + " and "
                    + row["between"][1].get<std::string>() + ": F "
                    + formatted("%.2f", row["F_test"]["F"].get<double>())
                    + formatted(", p %.2g\n", row["F_test"]["p"].get<double>());
        for (const Json& row : findings.sessions)
            text += row["tissue"].get<std::string>() + ", session " + std::to_string(row["session"].get<int>()) + ": "
                + line_of(row["box_MPa"]);
        for (const Json& row : findings.learning)
            if (const Json& test = row["t_test_of_deviations"]; test.contains("p"))
                text += "  " + row["tissue"].get<std::string>() + ", deviation in session 1 against session "
                    + std::to_string(test["sessions"][1].get<int>()) + ": t "
                    + formatted("%.2f", test["t"].get<double>()) + formatted(", p %.2g\n", test["p"].get<double>());
        return text;
    }

    std::string text_of(const haptics::QualityVerdict& verdict)
    {
        if (verdict.persons == 0)
            return {};
        return "questionnaire, " + std::to_string(verdict.persons) + " persons: authentic "
            + std::to_string(verdict.authenticity) + ", easy " + std::to_string(verdict.ease) + ", stable "
            + std::to_string(verdict.stability)
            + (verdict.passes() ? ": passes\n" : ": does not pass (each question needs 8 of 10 positive answers)\n");
    }

    Json document_of(const haptics::QualityVerdict& verdict)
    {
        return { { "persons", verdict.persons }, { "authenticity", verdict.authenticity }, { "ease", verdict.ease },
            { "stability", verdict.stability }, { "passes", verdict.passes() } };
    }

} // namespace

Outcome train_report(const std::filesystem::path& store_file, const std::filesystem::path& out, const Job& job)
{
    const haptics::TrialStore store(store_file);
    const std::vector<haptics::ElasticityTrial> trials = store.trials();
    if (trials.empty())
        throw InputError("there are no trials yet", store_file.string());
    Findings findings;
    for (const haptics::Tissue tissue : kTissues) {
        add_instructions(findings, trials, tissue);
        add_sessions(findings, trials, tissue);
    }
    const haptics::QualityVerdict verdict = haptics::judge(store.answers());
    Outcome outcome;
    outcome.document
        = { { "store", store_file.string() }, { "trials", trials.size() }, { "by_instruction", findings.instructions },
              { "spread_tests", findings.spreads }, { "by_session", findings.sessions },
              { "learning_tests", findings.learning }, { "questionnaire", document_of(verdict) } };
    outcome.text = text_of(findings) + text_of(verdict);
    if (out.empty())
        return outcome;
    make_folder(out);
    write_file_atomically(out / "trials.csv", haptics::trials_csv(trials));
    write_file_atomically(out / "trials.json", outcome.document.dump(2) + "\n");
    if (!findings.by_instruction.empty())
        write_box_chart(out / "instruction.png", findings.by_instruction, "instruction", job);
    if (!findings.by_session.empty())
        write_box_chart(out / "learning.png", findings.by_session, "session", job);
    outcome.text += "Written: " + (out / "trials.csv").string() + ", trials.json, instruction.png, learning.png\n";
    return outcome;
}

} // namespace retractor::ui::cli
