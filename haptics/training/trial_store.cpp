#include "haptics/training/trial_store.h"

#include "haptics/recording/csv_field.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <sqlite3.h>

#include <charconv>
#include <cmath>
#include <utility>

namespace retractor::haptics {

namespace {

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

    struct Close {
        void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
        void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
    };

} // namespace

struct TrialStore::State {
    std::string file;
    std::unique_ptr<sqlite3, Close> database;

    [[noreturn]] void fail(const std::string& what) const
    {
        throw IoError(what + ": " + sqlite3_errmsg(database.get()), file);
    }
    void run(const char* sql) const
    {
        if (sqlite3_exec(database.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK)
            fail("the trials' file cannot be used");
    }
};

namespace {

    /// A prepared statement with its values.
    class Statement {
    public:
        Statement(sqlite3* database, const std::string& file, const char* sql)
            : database_(database)
            , file_(file)
        {
            sqlite3_stmt* statement = nullptr;
            if (sqlite3_prepare_v2(database, sql, -1, &statement, nullptr) != SQLITE_OK)
                fail();
            statement_.reset(statement);
        }
        Statement& bind(const std::string& text)
        {
            check(sqlite3_bind_text(
                statement_.get(), ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
            return *this;
        }
        Statement& bind(double value)
        {
            check(sqlite3_bind_double(statement_.get(), ++bound_, value));
            return *this;
        }
        Statement& bind(int value)
        {
            check(sqlite3_bind_int(statement_.get(), ++bound_, value));
            return *this;
        }
        /// @return whether there is a row
        bool step()
        {
            const int result = sqlite3_step(statement_.get());
            if (result != SQLITE_ROW && result != SQLITE_DONE)
                fail();
            return result == SQLITE_ROW;
        }
        std::string text(int column) const
        {
            const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
            return bytes == nullptr
                ? std::string()
                : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column)));
        }
        double number(int column) const { return sqlite3_column_double(statement_.get(), column); }
        int integer(int column) const { return sqlite3_column_int(statement_.get(), column); }

    private:
        void check(int result) const
        {
            if (result != SQLITE_OK)
                fail();
        }
        [[noreturn]] void fail() const
        {
            throw IoError(std::string("the trials' file cannot be used: ") + sqlite3_errmsg(database_), file_);
        }

        sqlite3* database_;
        std::string file_;
        std::unique_ptr<sqlite3_stmt, Close> statement_;
        int bound_ = 0;
    };

} // namespace

TrialStore::TrialStore(const std::filesystem::path& file)
    : state_(std::make_unique<State>())
{
    state_->file = file.string();
    sqlite3* database = nullptr;
    const int opened
        = sqlite3_open_v2(state_->file.c_str(), &database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    state_->database.reset(database);
    if (opened != SQLITE_OK)
        state_->fail("the trials' file cannot be opened");
    constexpr int kPatience = 5000; // ms; waits while another program writes
    sqlite3_busy_timeout(database, kPatience);
    const auto pragma = [&](const char* sql) {
        Statement statement(database, state_->file, sql);
        return statement.step() ? statement.integer(0) : 0;
    };
    const int application = pragma("PRAGMA application_id"), version = pragma("PRAGMA user_version");
    const int tables = pragma("SELECT count(*) FROM sqlite_master");
    if (application == 0 && tables == 0) {
        state_->run("BEGIN IMMEDIATE");
        state_->run(kTables);
        state_->run(("PRAGMA application_id = " + std::to_string(kApplication)).c_str());
        state_->run(("PRAGMA user_version = " + std::to_string(kStoreVersion)).c_str());
        state_->run("COMMIT");
    } else if (application != kApplication)
        throw IoError("is another program's database", state_->file);
    else if (version != kStoreVersion)
        throw IoError(
            "has version " + std::to_string(version) + "; this program knows " + std::to_string(kStoreVersion),
            state_->file);
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
    Statement statement(
        state_->database.get(), state_->file, "INSERT OR REPLACE INTO elasticity VALUES (?, ?, ?, ?, ?)");
    statement.bind(e.name).bind(e.modulus_MPa).bind(e.poissons_ratio).bind(e.expert).bind(e.date).step();
}

std::vector<NamedElasticity> TrialStore::elasticities() const
{
    Statement statement(state_->database.get(), state_->file,
        "SELECT name, modulus_MPa, poissons_ratio, expert, date FROM elasticity ORDER BY name");
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
    state_->run("BEGIN IMMEDIATE");
    try {
        for (const ElasticityTrial& trial : trials) {
            Statement statement(state_->database.get(), state_->file,
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
        state_->run("COMMIT");
    } catch (...) {
        sqlite3_exec(state_->database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
        throw;
    }
}

std::vector<ElasticityTrial> TrialStore::trials() const
{
    Statement statement(state_->database.get(), state_->file,
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
            throw IoError("trial " + std::to_string(result.size() + 1) + " is damaged: " + error.what(), state_->file);
        }
        result.push_back(std::move(trial));
    }
    return result;
}

int TrialStore::next_session(const std::string& trainee) const
{
    Statement statement(
        state_->database.get(), state_->file, "SELECT coalesce(max(session), 0) + 1 FROM trial WHERE trainee = ?");
    statement.bind(trainee).step();
    return statement.integer(0);
}

void TrialStore::answer(const QualityAnswer& answer)
{
    if (answer.person.empty())
        throw InputError("an answer needs a person", "person");
    Statement statement(state_->database.get(), state_->file, "INSERT OR REPLACE INTO quality VALUES (?, ?, ?, ?)");
    statement.bind(answer.person)
        .bind(static_cast<int>(answer.authenticity))
        .bind(static_cast<int>(answer.ease))
        .bind(static_cast<int>(answer.stability))
        .step();
}

std::vector<QualityAnswer> TrialStore::answers() const
{
    Statement statement(state_->database.get(), state_->file,
        "SELECT person, authenticity, ease, stability FROM quality ORDER BY person");
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
