#pragma once
// Teaching elasticity by touch [seed B: expert stores what feels right, trainees look for it among twenty models]:
// which models, in which order, who chose what. Units MPa.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::haptics {

/// The source's twenty models, 0.2 to 4.0 in steps of 0.2, and the ten of its second study, 0.2 to 2.0.
std::vector<double> trial_models(int count = 20);

/// What a trainee was told before: nothing, words, or the right model to feel for a minute.
enum class Instruction : std::uint8_t { none, verbal, haptic };
std::string_view to_string(Instruction instruction) noexcept;
/// @throws InputError naming the three.
Instruction instruction_of(std::string_view text);

/// What is looked for.
enum class Tissue : std::uint8_t { normal, sclerotic };
std::string_view to_string(Tissue tissue) noexcept;
Tissue tissue_of(std::string_view text);
inline constexpr double kNormalMPa = 1.0, kScleroticMPa = 3.0; ///< what the source's surgeons agreed on

/// One choice of one person.
struct ElasticityTrial {
    std::string trainee;
    Instruction instruction = Instruction::none;
    int session = 1; ///< counted per trainee
    std::string date; ///< YYYY-MM-DD
    Tissue tissue = Tissue::normal;
    double chosen_MPa = 0.0, right_MPa = 0.0;
    std::uint64_t order_seed = 0; ///< with trial_order(): in which order the models were offered
};

/// @throws InputError naming the field: no trainee, a session below 1, a date of another form, moduli not positive.
void check_trial(const ElasticityTrial& trial);

/// A random order of `count` models: places in trial_models(); the same seed gives the same order on any machine.
std::vector<int> trial_order(int count, std::uint64_t seed);

/// A trainee of known sensitivity. Perception is of the logarithm of stiffness (Weber and Fechner), so that the spread
/// of what is chosen grows with the elasticity itself.
struct SimulatedTrainee {
    double noise = 0.12; ///< standard deviation of one touch, in log E
    double bias_normal = 0.0, bias_sclerotic = 0.0; ///< of what is remembered, in log E
    double learning = 0.5; ///< share of the bias that one learning stage takes away, and of `unsure`
    double unsure = 0.0; ///< standard deviation of what is remembered from test to test, in log E
    std::uint64_t seed = 1;
    std::uint64_t drawn = 0; ///< random numbers used so far

    /// Feels all models once in the order given and takes the one nearest to what is remembered.
    double choose(const std::vector<double>& models, const std::vector<int>& order, Tissue tissue);
    /// The learning stage: the right models are shown.
    void learn();

private:
    double normal_number();
};

/// The source's three studies with simulated people.
/// 1: eight surgeons choose both tissues among twenty models.
std::vector<ElasticityTrial> simulate_modelling_study(std::uint64_t seed);
/// 2: 18 students per instruction choose normal tissue among ten models.
std::vector<ElasticityTrial> simulate_recognition_study(std::uint64_t seed);
/// 3: ten students, seven sessions in 23 days, both tissues among twenty models, shown the right ones after each.
std::vector<ElasticityTrial> simulate_learning_study(std::uint64_t seed);

/// The ten-person questionnaire on haptic quality [Tang et al. 2020]: an aspect passes with eight positive answers in
/// ten.
struct QualityAnswer {
    std::string person;
    bool authenticity = false, ease = false, stability = false; ///< positive
};
struct QualityVerdict {
    int persons = 0;
    int authenticity = 0, ease = 0, stability = 0; ///< positive answers
    /// At least 80 % of at least ten persons.
    bool passes(int positive) const { return persons >= 10 && 10 * positive >= 8 * persons; }
    bool passes() const { return passes(authenticity) && passes(ease) && passes(stability); }
};
QualityVerdict judge(const std::vector<QualityAnswer>& answers);

} // namespace retractor::haptics
