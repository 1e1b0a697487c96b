#include "haptics/training/elasticity_trials.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace retractor::haptics {

namespace {

    /// A random number that depends on the seed and the index alone (splitmix64; Steele, Lea, Flood 2014).
    std::uint64_t mixed(std::uint64_t seed, std::uint64_t index)
    {
        std::uint64_t z = seed * 0x9e3779b97f4a7c15ULL + (index + 1) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31);
    }

    double unit(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53; }

    ElasticityTrial trial_of(std::string trainee, Instruction instruction, int session, std::string date, Tissue tissue,
        double chosen, std::uint64_t order_seed)
    {
        return { std::move(trainee), instruction, session, std::move(date), tissue, chosen,
            tissue == Tissue::normal ? kNormalMPa : kScleroticMPa, order_seed };
    }

    std::string person(const char* kind, int number) { return formatted("%s-%02d", kind, number); }

} // namespace

std::vector<double> trial_models(int count)
{
    if (count < 2 || count > 200)
        throw InputError("a test has 2 to 200 models, got " + std::to_string(count));
    std::vector<double> models;
    for (int i = 1; i <= count; ++i)
        models.push_back(0.2 * i);
    return models;
}

std::string_view to_string(Instruction instruction) noexcept
{
    constexpr std::array<std::string_view, 3> kNames { "none", "verbal", "haptic" };
    return kNames[static_cast<std::size_t>(instruction)];
}

Instruction instruction_of(std::string_view text)
{
    for (const Instruction one : { Instruction::none, Instruction::verbal, Instruction::haptic })
        if (text == to_string(one))
            return one;
    throw InputError("the instruction is none, verbal or haptic, got " + std::string(text));
}

std::string_view to_string(Tissue tissue) noexcept { return tissue == Tissue::normal ? "normal" : "sclerotic"; }

Tissue tissue_of(std::string_view text)
{
    for (const Tissue one : { Tissue::normal, Tissue::sclerotic })
        if (text == to_string(one))
            return one;
    throw InputError("the tissue is normal or sclerotic, got " + std::string(text));
}

void check_trial(const ElasticityTrial& trial)
{
    if (trial.trainee.empty())
        throw InputError("a trial needs a trainee", "trainee");
    if (trial.session < 1)
        throw InputError("sessions count from 1, got " + std::to_string(trial.session), "session");
    const auto digits = [&](std::size_t from, std::size_t count) {
        return std::all_of(trial.date.begin() + static_cast<std::ptrdiff_t>(from),
            trial.date.begin() + static_cast<std::ptrdiff_t>(from + count),
            [](char c) { return c >= '0' && c <= '9'; });
    };
    if (trial.date.size() != 10 || trial.date[4] != '-' || trial.date[7] != '-' || !digits(0, 4) || !digits(5, 2)
        || !digits(8, 2))
        throw InputError("a date is YYYY-MM-DD, got " + trial.date, "date");
    for (const double modulus : { trial.chosen_MPa, trial.right_MPa })
        if (!(modulus > 0.0) || !std::isfinite(modulus))
            throw InputError("an elasticity must be positive, got " + std::to_string(modulus), "chosen_MPa");
}

std::vector<int> trial_order(int count, std::uint64_t seed)
{
    std::vector<int> order(static_cast<std::size_t>(std::max(0, count)));
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = order.size(); i > 1; --i) // Fisher-Yates shuffle
        std::swap(order[i - 1], order[static_cast<std::size_t>(mixed(seed, i) % i)]);
    return order;
}

double SimulatedTrainee::normal_number()
{
    const double u = unit(mixed(seed, drawn)), v = unit(mixed(seed, drawn + 1));
    drawn += 2;
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v); // Box-Muller transform
}

double SimulatedTrainee::choose(const std::vector<double>& models, const std::vector<int>& order, Tissue tissue)
{
    const bool is_normal = tissue == Tissue::normal;
    const double remembered = std::log(is_normal ? kNormalMPa : kScleroticMPa)
        + (is_normal ? bias_normal : bias_sclerotic) + unsure * normal_number();
    double best = models.front(), least = std::numeric_limits<double>::infinity();
    for (const int place : order) {
        const double modulus = models[static_cast<std::size_t>(place)];
        const double off = std::abs(std::log(modulus) + noise * normal_number() - remembered);
        if (off < least) {
            least = off;
            best = modulus;
        }
    }
    return best;
}

void SimulatedTrainee::learn()
{
    bias_normal *= 1.0 - learning;
    bias_sclerotic *= 1.0 - learning;
    unsure *= 1.0 - learning;
}

std::vector<ElasticityTrial> simulate_modelling_study(std::uint64_t seed)
{
    const std::vector<double> models = trial_models();
    std::vector<ElasticityTrial> trials;
    for (int i = 1; i <= 8; ++i) {
        const std::uint64_t own = mixed(seed, static_cast<std::uint64_t>(i));
        SimulatedTrainee surgeon {
            .noise = 0.05, .bias_normal = 0.08, .bias_sclerotic = 0.08, .learning = 0.0, .unsure = 0.03, .seed = own
        };
        for (const Tissue tissue : { Tissue::normal, Tissue::sclerotic })
            trials.push_back(trial_of(person("surgeon", i), Instruction::none, 1, "2005-01-10", tissue,
                surgeon.choose(models, trial_order(20, own), tissue), own));
    }
    return trials;
}

std::vector<ElasticityTrial> simulate_recognition_study(std::uint64_t seed)
{
    const std::vector<double> models = trial_models(10);
    std::vector<ElasticityTrial> trials;
    for (const Instruction instruction : { Instruction::none, Instruction::verbal, Instruction::haptic })
        for (int i = 1; i <= 18; ++i) {
            const auto index = 100 * static_cast<std::uint64_t>(instruction) + static_cast<std::uint64_t>(i);
            const std::uint64_t own = mixed(seed, index);
            SimulatedTrainee student { .noise = 0.08, .seed = own };
            student.unsure = instruction == Instruction::none ? 0.7 : instruction == Instruction::verbal ? 0.5 : 0.1;
            trials.push_back(trial_of(person("student", i), instruction, 1, "2005-02-01", Tissue::normal,
                student.choose(models, trial_order(10, own), Tissue::normal), own));
        }
    return trials;
}

std::vector<ElasticityTrial> simulate_learning_study(std::uint64_t seed)
{
    const std::vector<double> models = trial_models();
    // About two sessions a week within 23 days.
    const std::array<const char*, 7> dates { "2005-03-01", "2005-03-04", "2005-03-08", "2005-03-11", "2005-03-15",
        "2005-03-18", "2005-03-23" };
    std::vector<ElasticityTrial> trials;
    for (int i = 1; i <= 10; ++i) {
        const std::uint64_t own = mixed(seed, 7000 + static_cast<std::uint64_t>(i));
        SimulatedTrainee student {
            .noise = 0.08, .bias_normal = 0.5, .bias_sclerotic = -0.3, .learning = 0.5, .unsure = 0.6, .seed = own
        };
        for (std::size_t session = 0; session < dates.size(); ++session) {
            for (const Tissue tissue : { Tissue::normal, Tissue::sclerotic }) {
                const std::uint64_t order = mixed(own, 100 + session);
                trials.push_back(trial_of(person("student", i), Instruction::haptic, static_cast<int>(session) + 1,
                    dates[session], tissue, student.choose(models, trial_order(20, order), tissue), order));
            }
            student.learn();
        }
    }
    return trials;
}

QualityVerdict judge(const std::vector<QualityAnswer>& answers)
{
    QualityVerdict verdict;
    for (const QualityAnswer& answer : answers) {
        ++verdict.persons;
        verdict.authenticity += answer.authenticity ? 1 : 0;
        verdict.ease += answer.ease ? 1 : 0;
        verdict.stability += answer.stability ? 1 : 0;
    }
    return verdict;
}

} // namespace retractor::haptics
