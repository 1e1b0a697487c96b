#pragma once
// Trials that teach elasticity by touch (Nakao et al., Transferring bioelasticity knowledge through haptic interaction,
// IEEE MultiMedia 13(3), 2006): an expert stores the elasticity that feels right, and trainees look for this elasticity
// among twenty models. The module lists the models, their order and the choices. Units MPa.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::haptics {

/// Young's moduli of the models, MPa. Twenty models of the paper: 0.2 to 4.0 in steps of 0.2. Ten models of its second
/// study: 0.2 to 2.0.
std::vector<double> trial_models(int count = 20);

/// Instruction of a trainee before the trial: none, words, or one minute of touching the right model.
enum class Instruction : std::uint8_t { none, verbal, haptic };
std::string_view to_string(Instruction instruction) noexcept;
/// @throws InputError naming the three instructions
Instruction instruction_of(std::string_view text);

/// The tissue that a trainee looks for.
enum class Tissue : std::uint8_t { normal, sclerotic };
std::string_view to_string(Tissue tissue) noexcept;
Tissue tissue_of(std::string_view text);
/// Values on which the surgeons of Nakao et al. 2006 agreed.
inline constexpr double kNormalMPa = 1.0, kScleroticMPa = 3.0;

/// One choice of one trainee.
struct ElasticityTrial {
    std::string trainee;
    Instruction instruction = Instruction::none;
    int session = 1; ///< counted per trainee
    std::string date; ///< YYYY-MM-DD
    Tissue tissue = Tissue::normal;
    double chosen_MPa = 0.0, right_MPa = 0.0;
    std::uint64_t order_seed = 0; ///< seed of trial_order() for the order in which the models were offered
};

/// @throws InputError naming the field: no trainee, a session below 1, a date of another form, or a modulus that is not
/// positive
void check_trial(const ElasticityTrial& trial);

/// A random order of `count` models, as indices into trial_models(). The same seed gives the same order on any machine.
std::vector<int> trial_order(int count, std::uint64_t seed);

/// A simulated trainee of known sensitivity. The trainee perceives the logarithm of stiffness (Weber and Fechner), so
/// the spread of the choices grows with the elasticity.
struct SimulatedTrainee {
    double noise = 0.12; ///< standard deviation of one touch, in log E
    double bias_normal = 0.0, bias_sclerotic = 0.0; ///< bias of the memory, in log E
    double learning = 0.5; ///< share by which one learning stage reduces the bias and `unsure`
    double unsure = 0.0; ///< standard deviation of the memory from test to test, in log E
    std::uint64_t seed = 1;
    std::uint64_t drawn = 0; ///< number of random numbers used so far

    /// Touches all models once in the given order and chooses the model nearest to the memory. @return its modulus, MPa
    double choose(const std::vector<double>& models, const std::vector<int>& order, Tissue tissue);
    /// The learning stage, which shows the right models.
    void learn();

private:
    double normal_number();
};

/// The three studies of Nakao et al. 2006 with simulated people.
/// Study 1: eight surgeons choose both tissues among twenty models.
std::vector<ElasticityTrial> simulate_modelling_study(std::uint64_t seed);
/// Study 2: 18 students per instruction choose normal tissue among ten models.
std::vector<ElasticityTrial> simulate_recognition_study(std::uint64_t seed);
/// Study 3: ten students choose both tissues among twenty models in seven sessions within 23 days, and are shown the
/// right models after each session.
std::vector<ElasticityTrial> simulate_learning_study(std::uint64_t seed);

/// The ten-person questionnaire on haptic quality of Tang et al. 2020. An aspect passes with eight positive answers in
/// ten.
struct QualityAnswer {
    std::string person;
    bool authenticity = false, ease = false, stability = false; ///< true: a positive answer
};
struct QualityVerdict {
    int persons = 0;
    int authenticity = 0, ease = 0, stability = 0; ///< number of positive answers
    /// Passes with at least ten persons and at least 80 % positive answers.
    bool passes(int positive) const { return persons >= 10 && 10 * positive >= 8 * persons; }
    bool passes() const { return passes(authenticity) && passes(ease) && passes(stability); }
};
QualityVerdict judge(const std::vector<QualityAnswer>& answers);

} // namespace retractor::haptics
