#include "haptics/training/trial_store.h"

#include "datasets/tables/sqlite_statement.h"
#include "haptics/recording/csv_field.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <charconv>
#include <cmath>
#include <utility>

namespace retractor::haptics {

namespace {

    using Statement = datasets::SqliteStatement;

    constexpr int kApplication = 0x52545254; // "RTRT", application id in the SQLite header
    constexpr int kStoreVersion = 1;

    constexpr const char* kTables = R"(
        CREATE TABLE elasticity (name TEXT PRIMARY KEY, modulus_MPa REAL NOT NULL, poissons_ratio REAL NOT NULL,
            expert TEXT NOT NULL, date TEXT NOT NULL);
        CREATE TABLE trial (id INTEGER PRIMARY KEY, trainee TEXT NOT NULL, instruction TEXT NOT NULL, session INTEGER NOT NULL,
            date TEXT NOT NULL, tissue TEXT NOT NULL, chosen_MPa REAL NOT NULL, right_MPa REAL NOT NULL,
            order_seed TEXT NOT NULL);
        CREATE TABLE quality (person TEXT PRIMARY KEY, authenticity INTEGER NOT NULL, ease INTEGER NOT NULL,
            stability INTEGER NOT NULL);
    )";

} // namespace

struct TrialStore::State {
    datasets::SqliteDatabase database;
};

TrialStore::TrialStore(const std::filesystem::path& file)
    : state_(std::make_unique<State>(State { datasets::open_sqlite(file, "the trials' file cannot be used") }))
{
    const datasets::SqliteDatabase& database = state_->database;
    const auto pragma = [&](const char* sql) {
        Statement statement(database, sql);
        return statement.step() ? statement.integer(0) : 0;
    };
    const int application = pragma("PRAGMA application_id"), version = pragma("PRAGMA user_version");
    const int tables = pragma("SELECT count(*) FROM sqlite_master");
    if (application == 0 && tables == 0) {
        database.run("BEGIN IMMEDIATE");
        database.run(kTables);
        database.run("PRAGMA application_id = " + std::to_string(kApplication));
        database.run("PRAGMA user_version = " + std::to_string(kStoreVersion));
        database.run("COMMIT");
    } else if (application != kApplication)
        throw IoError("is another program's database", database.file);
    else if (version != kStoreVersion)
        throw IoError(
            "has version " + std::to_string(version) + "; this program knows " + std::to_string(kStoreVersion),
            database.file);
}

TrialStore::~TrialStore() = default;

void TrialStore::keep(const NamedElasticity& e)
{
    if (e.name.empty())
        throw InputError("an elasticity needs a name", "name");
    if (!(e.modulus_MPa > 0.0) || !std::isfinite(e.modulus_MPa))
        throw InputError("Young's modulus must be positive, got " + std::to_string(e.modulus_MPa), "modulus_MPa");
    if (!(e.poissons_ratio > -1.0 && e.poissons_ratio < 0.5))
        throw InputError(
            "Poisson's ratio lies between -1 and 0.5, got " + std::to_string(e.poissons_ratio), "poissons_ratio");
    Statement statement(state_->database, "INSERT OR REPLACE INTO elasticity VALUES (?, ?, ?, ?, ?)");
    statement.bind(e.name).bind(e.modulus_MPa).bind(e.poissons_ratio).bind(e.expert).bind(e.date).step();
}

std::vector<NamedElasticity> TrialStore::elasticities() const
{
    Statement statement(
        state_->database, "SELECT name, modulus_MPa, poissons_ratio, expert, date FROM elasticity ORDER BY name");
    std::vector<NamedElasticity> result;
    while (statement.step())
        result.push_back(
            { statement.text(0), statement.text(3), statement.text(4), statement.number(1), statement.number(2) });
    return result;
}

void TrialStore::add(const std::vector<ElasticityTrial>& trials)
{
    for (const ElasticityTrial& trial : trials)
        check_trial(trial);
    state_->database.run("BEGIN IMMEDIATE");
    try {
        for (const ElasticityTrial& trial : trials) {
            Statement statement(state_->database,
                "INSERT INTO trial (trainee, instruction, session, date, tissue, chosen_MPa, right_MPa, order_seed) "
                "VALUES "
                "(?, ?, ?, ?, ?, ?, ?, ?)");
            statement.bind(trial.trainee)
                .bind(std::string(to_string(trial.instruction)))
                .bind(trial.session)
                .bind(trial.date)
                .bind(std::string(to_string(trial.tissue)))
                .bind(trial.chosen_MPa)
                .bind(trial.right_MPa)
                .bind(std::to_string(trial.order_seed)) // an unsigned 64-bit number does not fit SQLite's integers
                .step();
        }
        state_->database.run("COMMIT");
    } catch (...) {
        sqlite3_exec(state_->database.handle.get(), "ROLLBACK", nullptr, nullptr, nullptr);
        throw;
    }
}

std::vector<ElasticityTrial> TrialStore::trials() const
{
    Statement statement(state_->database,
        "SELECT trainee, instruction, session, date, tissue, chosen_MPa, right_MPa, order_seed FROM trial ORDER BY id");
    std::vector<ElasticityTrial> result;
    while (statement.step()) {
        const std::string seed = statement.text(7);
        ElasticityTrial trial { statement.text(0), Instruction::none, statement.integer(2), statement.text(3),
            Tissue::normal, statement.number(5), statement.number(6), 0 };
        try { // another program may have changed the file
            trial.instruction = instruction_of(statement.text(1));
            trial.tissue = tissue_of(statement.text(4));
            check_trial(trial);
            const auto [end, error] = std::from_chars(seed.data(), seed.data() + seed.size(), trial.order_seed);
            if (error != std::errc() || end != seed.data() + seed.size())
                throw InputError("the order's seed is not a whole number: \"" + seed + "\"");
        } catch (const InputError& error) {
            throw IoError(
                "trial " + std::to_string(result.size() + 1) + " is damaged: " + error.what(), state_->database.file);
        }
        result.push_back(std::move(trial));
    }
    return result;
}

int TrialStore::next_session(const std::string& trainee) const
{
    Statement statement(state_->database, "SELECT coalesce(max(session), 0) + 1 FROM trial WHERE trainee = ?");
    statement.bind(trainee).step();
    return statement.integer(0);
}

void TrialStore::answer(const QualityAnswer& answer)
{
    if (answer.person.empty())
        throw InputError("an answer needs a person", "person");
    Statement statement(state_->database, "INSERT OR REPLACE INTO quality VALUES (?, ?, ?, ?)");
    statement.bind(answer.person)
        .bind(static_cast<int>(answer.authenticity))
        .bind(static_cast<int>(answer.ease))
        .bind(static_cast<int>(answer.stability))
        .step();
}

std::vector<QualityAnswer> TrialStore::answers() const
{
    Statement statement(state_->database, "SELECT person, authenticity, ease, stability FROM quality ORDER BY person");
    std::vector<QualityAnswer> result;
    while (statement.step())
        result.push_back(
            { statement.text(0), statement.integer(1) != 0, statement.integer(2) != 0, statement.integer(3) != 0 });
    return result;
}

std::string trials_csv(const std::vector<ElasticityTrial>& trials)
{
    std::string csv = "trainee,instruction,session,date,tissue,chosen_MPa,right_MPa,order_seed\n";
    for (const ElasticityTrial& trial : trials) {
        csv += csv_field(trial.trainee) + "," + std::string(to_string(trial.instruction)) + ","
            + std::to_string(trial.session) + "," + trial.date + "," + std::string(to_string(trial.tissue)) + ","
            + formatted("%.17g,%.17g,%llu\n", trial.chosen_MPa, trial.right_MPa,
                static_cast<unsigned long long>(trial.order_seed));
    }
    return csv;
}

} // namespace retractor::haptics
