// How the controller speaks with the rest of the machine: commands, telemetry, black box.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "firmware_like/daemon/black_box.hpp"
#include "firmware_like/daemon/command_socket.hpp"
#include "firmware_like/daemon/options.hpp"
#include "firmware_like/daemon/telemetry_segment.hpp"
#include "tests/support/random.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/controller/black_box_reader.hpp"
#include "tools/io/csv.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/input_error.hpp"

namespace vergence {
namespace {

using test::TempDirectory;
using testing::Random;

// ---- commands
// -----------------------------------------------------------------------------------------------

class Operator {
 public:
  explicit Operator(const std::string& path) : handle_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    connected = ::connect(handle_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Operator() { ::close(handle_); }
  Operator(const Operator&) = delete;
  Operator& operator=(const Operator&) = delete;

  void say(const std::string& word) const { (void)::send(handle_, word.data(), word.size(), MSG_NOSIGNAL); }
  // Empty where nothing was answered.
  [[nodiscard]] std::string hear() const {
    std::array<char, 256> text{};
    const ssize_t got = ::recv(handle_, text.data(), text.size(), MSG_DONTWAIT);
    return got > 0 ? std::string(text.data(), static_cast<std::size_t>(got)) : "";
  }
  bool connected = false;

 private:
  int handle_;
};

class CommandSocketTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(socket.open(path.c_str()), SocketStatus::kOk); }
  std::string ask(const Operator& one, const std::string& word) {
    one.say(word);
    for (int i = 0; i < 3; ++i) socket.serve(0, "servo", "enabled");
    return one.hear();
  }

  TempDirectory folder;
  std::string path = (folder / "command").string();
  OperatorChannel channel;
  CommandSocket socket{channel};
};

TEST(Commands, AreExactlyTheWordsThereAre) {
  EXPECT_EQ(parse_command("arm").verb, CommandVerb::kOperate);
  EXPECT_EQ(parse_command("arm\n").command, OperatorCommand::kArm);
  EXPECT_EQ(parse_command("stop").command, OperatorCommand::kStop);
  EXPECT_EQ(parse_command("status").verb, CommandVerb::kStatus);
  for (const char* const word : {"", "\n", "ar", "armm", "ARM", " arm", "arm ", "arm\n\n", "arm;stop"}) {
    EXPECT_EQ(parse_command(word).verb, CommandVerb::kMalformed) << word;
  }
  EXPECT_EQ(parse_command(std::string_view("arm\0", 4)).verb, CommandVerb::kMalformed);
}

TEST(Commands, NoiseIsNone) {
  Random random(1);
  for (int trial = 0; trial < 100'000; ++trial) {
    std::string noise(static_cast<std::size_t>(random.below(40)), ' ');
    for (char& letter : noise) letter = static_cast<char>(random.below(256));
    const ParsedCommand parsed = parse_command(noise);
    EXPECT_TRUE(parsed.verb == CommandVerb::kMalformed || noise.size() <= 7);
  }
}

TEST(Commands, AreForTheOwnerTheGroupAndRoot) {
  const std::array<gid_t, 2> groups = {100, 44};
  EXPECT_TRUE(may_command(0, {}, 500, 44));
  EXPECT_TRUE(may_command(500, {}, 500, 44));
  EXPECT_TRUE(may_command(501, groups, 500, 44));
  EXPECT_FALSE(may_command(501, groups, 500, 45));
  EXPECT_FALSE(may_command(501, {}, 500, 44));
}

TEST_F(CommandSocketTest, HandsCommandsOnAndAnswers) {
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0660U);
  const Operator one(path);
  ASSERT_TRUE(one.connected);
  EXPECT_EQ(ask(one, "arm"), "ok\n");
  EXPECT_EQ(channel.take(), OperatorCommand::kArm);
  EXPECT_EQ(ask(one, "status"), "ok servo enabled\n");
  EXPECT_FALSE(channel.take());
  EXPECT_EQ(ask(one, "dance").substr(0, 6), "error ");
  EXPECT_EQ(ask(one, std::string(1000, 'a')).substr(0, 6), "error ");
  EXPECT_FALSE(channel.take());
  EXPECT_EQ(ask(one, "stop\n"), "ok\n");
  EXPECT_EQ(channel.take(), OperatorCommand::kStop);
  EXPECT_EQ(socket.counts().malformed, 2U);
}

TEST_F(CommandSocketTest, ServesSeveralAndSendsTheRestAway) {
  std::vector<std::unique_ptr<Operator>> all;
  for (int i = 0; i < kMaxOperators + 3; ++i) {
    all.push_back(std::make_unique<Operator>(path));
    socket.serve(0, "idle", "disabled");
  }
  EXPECT_EQ(socket.counts().too_many, 3U);
  EXPECT_EQ(ask(*all[kMaxOperators - 1], "hold"), "ok\n");
  EXPECT_EQ(ask(*all[kMaxOperators], "hold"), "");
  all.erase(all.begin());
  for (int i = 0; i < 3; ++i) socket.serve(0, "idle", "disabled");
  const Operator late(path);
  socket.serve(0, "idle", "disabled");
  EXPECT_EQ(ask(late, "hold"), "ok\n");
}

TEST_F(CommandSocketTest, ReplacesWhatAKilledOneLeftAndNothingElse) {
  OperatorChannel other_channel;
  CommandSocket other{other_channel};
  EXPECT_EQ(other.open(path.c_str()), SocketStatus::kInUse);
  const std::string left = (folder / "left").string();
  {
    const int handle = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(left.begin(), left.end(), address.sun_path);
    ASSERT_EQ(::bind(handle, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(handle);
  }
  EXPECT_EQ(other.open(left.c_str()), SocketStatus::kOk);
  const std::string file = (folder / "file").string();
  test::write_file(file, "precious");
  EXPECT_EQ(other.open(file.c_str()), SocketStatus::kCannotBind);
  EXPECT_EQ(test::read_file(file), "precious");
  EXPECT_EQ(other.open(""), SocketStatus::kBadPath);
  EXPECT_EQ(other.open(std::string(200, 'a').c_str()), SocketStatus::kBadPath);
  EXPECT_EQ(other.open((folder / "no/such/folder").c_str()), SocketStatus::kCannotBind);
}

// ---- telemetry
// ----------------------------------------------------------------------------------------------

TelemetryRecord record_of(std::uint64_t n) {
  TelemetryRecord record;
  record.t_ns = static_cast<std::int64_t>(n);
  record.period = n;
  record.joint_rad.fill(static_cast<double>(n));
  record.tasks.back().runs = n;
  return record;
}

bool is_whole(const TelemetryRecord& record) {
  return record.t_ns == static_cast<std::int64_t>(record.period) &&
         record.tasks.back().runs == record.period &&
         record.joint_rad.front() == static_cast<double>(record.period) &&
         record.joint_rad.back() == static_cast<double>(record.period);
}

TEST(Telemetry, IsReadWholeWhileItIsWritten) {
  const std::string name = "/vergence-test-" + std::to_string(::getpid());
  TelemetryWriter writer;
  ASSERT_EQ(writer.open(name.c_str()), SegmentStatus::kOk);
  TelemetryReader reader;
  ASSERT_EQ(reader.open(name.c_str()), SegmentStatus::kOk);
  EXPECT_EQ(reader.writer_pid(), ::getpid());
  TelemetryRecord record;
  EXPECT_FALSE(reader.read(record));
  std::atomic<bool> stop{false};
  std::thread writing([&] {
    for (std::uint64_t n = 1; !stop; ++n) writer.write(record_of(n));
  });
  std::uint64_t last = 0;
  for (int i = 0; i < 20'000;) {
    if (!reader.read(record)) continue;
    ASSERT_TRUE(is_whole(record));
    ASSERT_GE(record.period, last);
    last = record.period;
    ++i;
  }
  stop = true;
  writing.join();
  writer.close();
  EXPECT_TRUE(reader.read(record));  // what was mapped stays
  TelemetryReader late;
  EXPECT_EQ(late.open(name.c_str()), SegmentStatus::kCannotOpen);
}

TEST(Telemetry, RefusesWhatIsNotItsOwn) {
  const std::string name = "/vergence-test-other-" + std::to_string(::getpid());
  TelemetryReader reader;
  const auto with = [&](std::size_t bytes, std::uint32_t version, char first) {
    const int file = ::shm_open(name.c_str(), O_CREAT | O_RDWR | O_TRUNC, 0600);
    EXPECT_EQ(::ftruncate(file, static_cast<off_t>(bytes)), 0);
    TelemetryMemory memory;
    memory.version = version;
    memory.magic[0] = first;
    EXPECT_GT(::pwrite(file, &memory, std::min(bytes, sizeof memory), 0), 0);
    ::close(file);
    return reader.open(name.c_str());
  };
  EXPECT_EQ(with(sizeof(TelemetryMemory), kTelemetryVersion, 'V'), SegmentStatus::kOk);
  EXPECT_EQ(with(sizeof(TelemetryMemory), kTelemetryVersion + 1, 'V'), SegmentStatus::kOtherVersion);
  EXPECT_EQ(with(sizeof(TelemetryMemory), kTelemetryVersion, 'X'), SegmentStatus::kNotTelemetry);
  EXPECT_EQ(with(100, kTelemetryVersion, 'V'), SegmentStatus::kOtherVersion);
  ::shm_unlink(name.c_str());
  TelemetryWriter writer;
  for (const char* const bad : {"", "/", "no-slash"}) EXPECT_EQ(writer.open(bad), SegmentStatus::kBadName);
  EXPECT_EQ(writer.open(("/" + std::string(80, 'a')).c_str()), SegmentStatus::kBadName);
}

// ---- black box
// ----------------------------------------------------------------------------------------------

class BlackBoxTest : public ::testing::Test {
 protected:
  void record(std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t n = from; n < to; ++n) box->record(record_of(n));
  }
  void look(std::uint64_t n) {
    const std::vector<std::uint8_t> rgb(320 * 240 * 3, static_cast<std::uint8_t>(n));
    StereoFrame frame;
    frame.sequence = n;
    frame.stamp_ns = static_cast<std::int64_t>(n) * kBoxPictureEvery_ns;
    frame.left = {rgb.data(), 320, 240, 320 * 3, PixelFormat::kRgb24, nullptr, 0};
    frame.right = frame.left;
    box->look(frame);
  }
  std::unique_ptr<BlackBox> box = std::make_unique<BlackBox>();
  TempDirectory folder;
  std::string path = (folder / "box").string();
};

TEST_F(BlackBoxTest, KeepsTheLastAndASecondMore) {
  record(0, 3 * kBoxRecords);
  EXPECT_TRUE(box->trigger(77));
  EXPECT_FALSE(box->trigger(78));
  EXPECT_FALSE(box->is_frozen());
  record(3 * kBoxRecords, 3 * kBoxRecords + kBoxTailRecords + 1000);
  ASSERT_TRUE(box->is_frozen());
  ASSERT_EQ(box->records(), kBoxRecords);
  EXPECT_EQ(box->fault_ns(), 77);
  EXPECT_EQ(box->record_at(kBoxRecords - 1).period, 3 * kBoxRecords + kBoxTailRecords - 1);
  EXPECT_EQ(box->record_at(0).period, 2 * kBoxRecords + kBoxTailRecords);
  box->release();
  record(9, 10);
  EXPECT_FALSE(box->is_frozen());
  EXPECT_TRUE(box->trigger(80));
}

TEST_F(BlackBoxTest, TakesPicturesNowAndThen) {
  for (std::uint64_t n = 1; n <= kBoxPictures + 20; ++n) {
    look(n);
    look(n);  // too soon
  }
  EXPECT_EQ(box->pairs(), kBoxPictures);
  EXPECT_EQ(box->pair_at(0).sequence, 21U);
  EXPECT_EQ(box->pair_at(kBoxPictures - 1).sequence, kBoxPictures + 20U);
  EXPECT_EQ(box->pair_at(0).left.luma[0], 21);
  EXPECT_EQ(box->pair_at(0).left.cb[100], 128);
}

TEST_F(BlackBoxTest, SeesEveryFormatAlike) {
  // One colour in four formats: Y 76, Cb 85, Cr 255, which is red.
  constexpr int kWidth = 160;
  constexpr int kHeight = 120;
  std::vector<std::uint8_t> rgb, yuyv, uyvy, luma, chroma;
  for (int i = 0; i < kWidth * kHeight / 2; ++i) {
    for (int k = 0; k < 2; ++k) rgb.insert(rgb.end(), {255, 0, 0});
    yuyv.insert(yuyv.end(), {76, 85, 76, 255});
    uyvy.insert(uyvy.end(), {85, 76, 255, 76});
    luma.insert(luma.end(), {76, 76});
    chroma.insert(chroma.end(), {85, 255});
  }
  const std::array views = {
      ImageView{rgb.data(), kWidth, kHeight, kWidth * 3, PixelFormat::kRgb24, nullptr, 0},
      ImageView{yuyv.data(), kWidth, kHeight, kWidth * 2, PixelFormat::kYuyv, nullptr, 0},
      ImageView{uyvy.data(), kWidth, kHeight, kWidth * 2, PixelFormat::kUyvy, nullptr, 0},
      ImageView{luma.data(), kWidth, kHeight, kWidth, PixelFormat::kNv12, chroma.data(), kWidth},
  };
  for (const ImageView& view : views) {
    const auto picture = std::make_unique<BoxPicture>();
    take_picture(view, *picture);
    for (std::size_t i = 0; i < BoxPicture::kPixels; i += 701) {
      EXPECT_EQ(picture->luma[i], 76);
      EXPECT_EQ(picture->cb[i], 85);
      EXPECT_EQ(picture->cr[i], 255);
    }
  }
}

TEST_F(BlackBoxTest, IsWrittenAndUnpacked) {
  for (std::uint64_t n = 1; n <= 5; ++n) look(n);
  record(0, 1000);
  (void)box->trigger(2'000'000'000);
  record(1000, 1000 + kBoxTailRecords);
  BlackBoxFile file;
  ASSERT_EQ(file.prepare(path.c_str()), BoxFileStatus::kOk);
  EXPECT_EQ(std::filesystem::file_size(path + ".pending"), kBoxFileBytes);
  ASSERT_EQ(file.save(*box), BoxFileStatus::kOk);
  EXPECT_EQ(std::string(file.saved_as()), path + ".1");
  EXPECT_FALSE(std::filesystem::exists(path + ".pending"));
  const tools::BoxSummary summary = tools::unpack_black_box(path + ".1", folder / "out");
  EXPECT_EQ(summary.records, 1000 + kBoxTailRecords);
  EXPECT_EQ(summary.pairs, 5U);
  EXPECT_DOUBLE_EQ(summary.fault_s, 2);
  const tools::Csv log = tools::read_csv(folder / "out/log.csv");
  ASSERT_EQ(log.rows.size(), 1000 + kBoxTailRecords);
  EXPECT_EQ(log.columns[1], "period");
  EXPECT_DOUBLE_EQ(log.rows[700].values[1], 700);
  const tools::RgbImage picture = tools::read_png_rgb(folder / "out/pictures/0004_right.png");
  EXPECT_EQ(picture.width_px, kBoxPictureWidth);
  EXPECT_EQ(*picture.at(3, 4), 5);

  // Never over an older one; and when there is no place left, none at all.
  for (int n = 2; n <= BlackBoxFile::kMostFiles; ++n) {
    ASSERT_EQ(file.prepare(path.c_str()), BoxFileStatus::kOk);
    ASSERT_EQ(file.save(*box), BoxFileStatus::kOk);
  }
  ASSERT_EQ(file.prepare(path.c_str()), BoxFileStatus::kOk);
  EXPECT_EQ(file.save(*box), BoxFileStatus::kTooMany);
}

TEST_F(BlackBoxTest, RefusesToUnpackWhatIsBroken) {
  record(0, 100);
  (void)box->trigger(0);
  record(100, 100 + kBoxTailRecords);
  BlackBoxFile file;
  ASSERT_EQ(file.prepare(path.c_str()), BoxFileStatus::kOk);
  ASSERT_EQ(file.save(*box), BoxFileStatus::kOk);
  const std::string whole = test::read_file(path + ".1");
  const auto refuses = [&](const std::string& content) {
    test::write_file(folder / "broken", content);
    EXPECT_THROW((void)tools::unpack_black_box(folder / "broken", folder / "none"), tools::InputError);
    EXPECT_FALSE(std::filesystem::exists(folder / "none"));
  };
  refuses("");
  refuses(whole.substr(0, 20));
  refuses(whole.substr(0, whole.size() - 1));
  refuses(whole + "x");
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    std::string changed = whole;
    const auto at = static_cast<std::size_t>(random.below(trial < 40 ? 36 : static_cast<int>(whole.size())));
    changed[at] = static_cast<char>(changed[at] ^ (1 << random.below(8)));
    refuses(changed);
  }
}

TEST_F(BlackBoxTest, NoticesAFullDiskBeforehand) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 4096;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  BlackBoxFile file;
  const BoxFileStatus status = file.prepare(path.c_str());
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, handler);
  EXPECT_EQ(status, BoxFileStatus::kNoRoom);
  EXPECT_FALSE(file.is_prepared());
  EXPECT_FALSE(std::filesystem::exists(path + ".pending"));
  EXPECT_EQ(file.save(*box), BoxFileStatus::kCannotSave);
  EXPECT_EQ(file.prepare((folder / "no/such").c_str()), BoxFileStatus::kCannotOpen);
  EXPECT_EQ(file.prepare(""), BoxFileStatus::kBadPath);
}

// ---- command line
// -------------------------------------------------------------------------------------------

TEST(DaemonOptions, AreParsed) {
  const auto parse = [](std::vector<const char*> arguments, DaemonOptions& options) {
    const char* problem = "";
    arguments.insert(arguments.begin(), "vergenced");
    return parse_options(static_cast<int>(arguments.size()), const_cast<char**>(arguments.data()), options,
                         problem);
  };
  DaemonOptions options;
  EXPECT_FALSE(parse({}, options));
  EXPECT_FALSE(parse({"--config"}, options));
  EXPECT_FALSE(parse({"--config", "a", "--realtime=perhaps"}, options));
  EXPECT_FALSE(parse({"a"}, options));
  EXPECT_TRUE(parse({"--config=b", "--check"}, options));
  EXPECT_STREQ(options.config, "b");
  EXPECT_TRUE(options.checks_only);
  EXPECT_EQ(options.realtime, rt::RealtimePolicy::kEnforce);
  EXPECT_TRUE(parse({"--config", "a", "--realtime=ignore"}, options));
  EXPECT_EQ(options.realtime, rt::RealtimePolicy::kIgnore);
  DaemonOptions help;
  EXPECT_TRUE(parse({"--help"}, help));
}

}  // namespace
}  // namespace vergence
