#include "hal/canopen/socket_can.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/netlink.h>
#include <linux/can/raw.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

#include "hal/clock.hpp"

namespace vergence::canopen {
namespace {

// Error frames are decoded elsewhere, by numbers that are the kernel's.
static_assert(kErrorTxTimeout == CAN_ERR_TX_TIMEOUT && kErrorLostArbitration == CAN_ERR_LOSTARB &&
              kErrorController == CAN_ERR_CRTL && kErrorProtocol == CAN_ERR_PROT &&
              kErrorTransceiver == CAN_ERR_TRX && kErrorNoAcknowledge == CAN_ERR_ACK &&
              kErrorBusOff == CAN_ERR_BUSOFF && kErrorBus == CAN_ERR_BUSERROR &&
              kErrorRestarted == CAN_ERR_RESTARTED);
static_assert(kControllerRxOverflow == CAN_ERR_CRTL_RX_OVERFLOW &&
              kControllerTxOverflow == CAN_ERR_CRTL_TX_OVERFLOW &&
              kControllerWarning == (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING) &&
              kControllerPassive == (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE) &&
              kControllerActive == CAN_ERR_CRTL_ACTIVE);

constexpr std::size_t kMostFilters = 64;

std::int64_t to_ns(const timespec& time) {
  return std::int64_t{time.tv_sec} * kNsPerSecond + time.tv_nsec;
}

can_frame to_kernel(const CanFrame& frame) {
  can_frame out{};
  out.can_id = frame.id & CAN_SFF_MASK;
  if (frame.is_remote) out.can_id |= CAN_RTR_FLAG;
  out.can_dlc = std::min<std::uint8_t>(frame.size, CAN_MAX_DLEN);
  std::copy(frame.data.begin(), frame.data.end(), std::begin(out.data));
  return out;
}

CanFrame from_kernel(const can_frame& in) {
  CanFrame frame;
  frame.is_error = (in.can_id & CAN_ERR_FLAG) != 0;
  frame.is_remote = !frame.is_error && (in.can_id & CAN_RTR_FLAG) != 0;
  frame.id = in.can_id & (frame.is_error ? CAN_ERR_MASK : CAN_SFF_MASK);
  frame.size = std::min<std::uint8_t>(in.can_dlc, CAN_MAX_DLEN);
  std::copy(std::begin(in.data), std::end(in.data), frame.data.begin());
  return frame;
}

template <typename T>
bool set_option(int socket, int level, int option, const T& value) {
  return setsockopt(socket, level, option, &value, sizeof value) == 0;
}

}  // namespace

const char* describe(SocketStep step) {
  switch (step) {
    case SocketStep::kOk: return "ok";
    case SocketStep::kName: return "the name of a CAN interface is empty or too long";
    case SocketStep::kSocket: return "no CAN socket: is the kernel's module can_raw there?";
    case SocketStep::kInterface: return "no such CAN interface: `ip link` lists them";
    case SocketStep::kFilter: return "the CAN filters were refused";
    case SocketStep::kErrorFilter: return "CAN error frames were refused";
    case SocketStep::kOverflowCount: return "the count of lost CAN frames was refused";
    case SocketStep::kTimestamps: return "times of reception were refused";
    case SocketStep::kBind: return "the CAN interface could not be bound: is it up?";
  }
  return "unknown step";
}

SocketCan::~SocketCan() {
  close();
}

void SocketCan::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  next_ = 0;
  received_count_ = 0;
  nothing_more_ = false;
}

SocketStep SocketCan::open(const char* interface, std::span<const CanFilter> filters) {
  close();
  health_ = {};
  restart_ = {};
  lost_by_kernel_ = 0;
  errno_ = 0;
  const SocketStep step = set_up(interface, filters);
  if (step != SocketStep::kOk) {
    errno_ = errno;
    close();
  }
  return step;
}

SocketStep SocketCan::set_up(const char* interface, std::span<const CanFilter> filters) {
  ifreq request{};
  const std::size_t length = std::strlen(interface);
  if (length == 0 || length >= sizeof request.ifr_name) {
    errno = EINVAL;
    return SocketStep::kName;
  }
  std::memcpy(request.ifr_name, interface, length);
  socket_ = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (socket_ < 0) return SocketStep::kSocket;
  if (ioctl(socket_, SIOCGIFINDEX, &request) != 0) return SocketStep::kInterface;
  interface_ = request.ifr_ifindex;

  if (filters.size() > kMostFilters) {
    errno = E2BIG;
    return SocketStep::kFilter;
  }
  std::array<can_filter, kMostFilters> wanted{};
  for (std::size_t i = 0; i < filters.size(); ++i) {
    // Of the standard format, and no remote requests.
    wanted[i] = {filters[i].id, filters[i].mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
  }
  const auto bytes = static_cast<socklen_t>(filters.size() * sizeof(can_filter));
  if (setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FILTER, wanted.data(), bytes) != 0) return SocketStep::kFilter;
  if (!set_option(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK})) {
    return SocketStep::kErrorFilter;
  }
  if (!set_option(socket_, SOL_SOCKET, SO_RXQ_OVFL, int{1})) return SocketStep::kOverflowCount;
  if (!set_option(socket_, SOL_SOCKET, SO_TIMESTAMPNS, int{1})) return SocketStep::kTimestamps;

  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = interface_;
  // The socket interface of C takes every address by this cast.
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return SocketStep::kBind;
  }
  return SocketStep::kOk;
}

void SocketCan::note_failure(int error) {
  errno_ = error;
  if (health_.state == BusState::kOff) return;  // which a restart mends
  if (error == ENETDOWN || error == ENODEV || error == ENXIO || error == EBADF) {
    health_.state = BusState::kDown;
  }
}

void SocketCan::process(std::int64_t now_ns) {
  nothing_more_ = false;  // that was a period ago
  timespec kernel{};
  if (clock_gettime(CLOCK_REALTIME, &kernel) == 0) stamp_offset_ns_ = now_ns - to_ns(kernel);
  if (restart_.is_due(now_ns, health_.state == BusState::kOff) && ask_for_restart()) ++health_.restarts;
}

std::size_t SocketCan::send(std::span<const CanFrame> frames) {
  std::size_t taken = 0;
  while (taken < frames.size()) {
    const std::size_t count = std::min(frames.size() - taken, kMostAtOnce);
    std::array<can_frame, kMostAtOnce> out{};
    std::array<iovec, kMostAtOnce> data{};
    std::array<mmsghdr, kMostAtOnce> messages{};
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = to_kernel(frames[taken + i]);
      data[i] = {&out[i], sizeof out[i]};
      messages[i].msg_hdr.msg_iov = &data[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    // Of fewer than asked for, the next call says why.
    const int sent = sendmmsg(socket_, messages.data(), static_cast<unsigned>(count), 0);
    if (sent <= 0) break;
    taken += static_cast<std::size_t>(sent);
    if (health_.state == BusState::kDown) health_.state = BusState::kActive;
  }
  if (taken < frames.size()) {
    const int error = errno;
    const auto left = static_cast<std::uint32_t>(frames.size() - taken);
    (error == ENOBUFS || error == EAGAIN ? health_.tx_refused : health_.tx_failed) += left;
    note_failure(error);
  }
  return taken;
}

// False where there is nothing.
bool SocketCan::fetch() {
  // Fewer than asked for were all there was: no need to ask again, but for once.
  if (std::exchange(nothing_more_, false)) return false;
  next_ = 0;
  received_count_ = 0;
  constexpr std::size_t kMore = CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t));
  struct alignas(cmsghdr) More {
    std::array<char, kMore> bytes;
  };
  std::array<can_frame, kMostAtOnce> in{};
  std::array<iovec, kMostAtOnce> data{};
  std::array<More, kMostAtOnce> more{};
  std::array<mmsghdr, kMostAtOnce> messages{};
  for (std::size_t i = 0; i < kMostAtOnce; ++i) {
    data[i] = {&in[i], sizeof in[i]};
    messages[i].msg_hdr.msg_iov = &data[i];
    messages[i].msg_hdr.msg_iovlen = 1;
    messages[i].msg_hdr.msg_control = more[i].bytes.data();
    messages[i].msg_hdr.msg_controllen = more[i].bytes.size();
  }
  const int got = recvmmsg(socket_, messages.data(), kMostAtOnce, MSG_DONTWAIT, nullptr);
  if (got < 0 && errno != EAGAIN) note_failure(errno);
  std::uint32_t lost = lost_by_kernel_;  // said of a frame only where it is not zero
  for (std::size_t i = 0; static_cast<int>(i) < got; ++i) {
    if (messages[i].msg_len != sizeof in[i]) continue;
    Received& received = received_[received_count_++];
    received.frame = from_kernel(in[i]);
    msghdr& header = messages[i].msg_hdr;
    for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
      if (part->cmsg_level != SOL_SOCKET) continue;
      if (part->cmsg_type == SO_TIMESTAMPNS) {
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
        received.frame.stamp_ns = to_ns(stamp) + stamp_offset_ns_;
      } else if (part->cmsg_type == SO_RXQ_OVFL) {
        std::memcpy(&lost, CMSG_DATA(part), sizeof lost);
      }
    }
    received.lost = lost;
  }
  nothing_more_ = received_count_ > 0 && got < static_cast<int>(kMostAtOnce);
  return received_count_ > 0;
}

bool SocketCan::receive(CanFrame& frame) {
  // Error frames are counted on the way, but not without end.
  constexpr int kMostErrorFrames = 64;
  for (int i = 0; i < kMostErrorFrames; ++i) {
    if (next_ == received_count_ && !fetch()) return false;
    const Received& received = received_[next_++];
    frame = received.frame;
    health_.rx_overflows += received.lost - lost_by_kernel_;  // the kernel's count goes on for ever
    lost_by_kernel_ = received.lost;
    if (!frame.is_error) return true;
    count_errors(health_, decode_errors(frame));
  }
  return false;
}

// What `ip link set can0 type can restart` asks for, as a message to the kernel's routing socket.
bool SocketCan::ask_for_restart() {
  struct Message {
    nlmsghdr header{};
    ifinfomsg link{};
    std::array<char, 64> attributes{};
  } message;
  static_assert(offsetof(Message, attributes) == NLMSG_SPACE(sizeof(ifinfomsg)));
  std::size_t used = 0;
  const auto open_attribute = [&](std::uint16_t type, const void* value, std::size_t size) {
    const rtattr attribute{static_cast<unsigned short>(RTA_LENGTH(size)), type};
    std::memcpy(message.attributes.data() + used, &attribute, sizeof attribute);
    if (size > 0) std::memcpy(message.attributes.data() + used + RTA_LENGTH(0), value, size);
    used += RTA_SPACE(size);
  };
  const auto close_attribute = [&](std::size_t begin) {
    const auto length = static_cast<unsigned short>(used - begin);
    std::memcpy(message.attributes.data() + begin, &length, sizeof length);
  };
  const std::uint32_t restart = 1;
  const std::size_t info = used;
  open_attribute(IFLA_LINKINFO, nullptr, 0);
  open_attribute(IFLA_INFO_KIND, "can", 3);
  const std::size_t details = used;
  open_attribute(IFLA_INFO_DATA, nullptr, 0);
  open_attribute(IFLA_CAN_RESTART, &restart, sizeof restart);
  close_attribute(details);
  close_attribute(info);

  message.header.nlmsg_len = static_cast<std::uint32_t>(NLMSG_LENGTH(sizeof(ifinfomsg)) + used);
  message.header.nlmsg_type = RTM_NEWLINK;
  message.header.nlmsg_flags = NLM_F_REQUEST;
  message.link.ifi_family = AF_UNSPEC;
  message.link.ifi_index = interface_;
  const int routing = ::socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (routing < 0) return false;
  const ssize_t sent = ::send(routing, &message, message.header.nlmsg_len, 0);
  ::close(routing);
  return sent == static_cast<ssize_t>(message.header.nlmsg_len);
}

}  // namespace vergence::canopen
