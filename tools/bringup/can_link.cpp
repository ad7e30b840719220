#include "tools/bringup/can_link.hpp"

#include <linux/can/netlink.h>

#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace vergence::tools {
namespace {

using Bytes = std::span<const std::byte>;

template <typename T>
std::optional<T> value_of(Bytes bytes) {
  if (bytes.size() < sizeof(T)) return std::nullopt;
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

std::string_view text_of(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.substr(0, text.find('\0'));
}

// Calls take(type, payload) for each attribute that is whole.
template <typename Take>
void for_each_attribute(Bytes bytes, Take&& take) {
  while (const auto header = value_of<rtattr>(bytes)) {
    if (header->rta_len < sizeof(rtattr) || header->rta_len > bytes.size()) return;
    take(header->rta_type & NLA_TYPE_MASK, bytes.first(header->rta_len).subspan(sizeof(rtattr)));
    bytes = bytes.subspan(std::min<std::size_t>(RTA_ALIGN(header->rta_len), bytes.size()));
  }
}

void take_can(Bytes data, CanLink& link) {
  for_each_attribute(data, [&](int type, Bytes value) {
    if (type == IFLA_CAN_BITTIMING) {
      const auto timing = value_of<can_bittiming>(value);
      if (timing && timing->bitrate != 0) link.bitrate_bit_per_s = timing->bitrate;
    } else if (type == IFLA_CAN_STATE) {
      link.state = value_of<std::uint32_t>(value);
    } else if (type == IFLA_CAN_RESTART_MS) {
      link.restart_ms = value_of<std::uint32_t>(value);
    } else if (type == IFLA_CAN_BERR_COUNTER) {
      if (const auto counter = value_of<can_berr_counter>(value))
        link.errors = {counter->txerr, counter->rxerr};
    }
  });
}

void take_kind(Bytes info, CanLink& link) {
  for_each_attribute(info, [&](int type, Bytes value) {
    if (type == IFLA_INFO_KIND) link.is_virtual = text_of(value) == "vcan" || text_of(value) == "vxcan";
    if (type == IFLA_INFO_DATA) take_can(value, link);
  });
}

struct Request {
  nlmsghdr header{};
  ifinfomsg link{};
};

}  // namespace

CanLink parse_link(Bytes message) {
  CanLink link;
  const auto header = value_of<nlmsghdr>(message);
  if (!header || header->nlmsg_len > message.size() || header->nlmsg_len < NLMSG_HDRLEN) return link;
  const Bytes body = message.first(header->nlmsg_len).subspan(NLMSG_HDRLEN);
  if (header->nlmsg_type == NLMSG_ERROR) {
    link.was_told = body.size() >= sizeof(nlmsgerr);  // there is no such interface
    return link;
  }
  const auto info = value_of<ifinfomsg>(body);
  if (header->nlmsg_type != RTM_NEWLINK || !info) return link;
  link.was_told = true;
  link.exists = true;
  link.is_can = info->ifi_type == ARPHRD_CAN;
  link.is_up = (info->ifi_flags & IFF_UP) != 0;
  for_each_attribute(body.subspan(NLMSG_ALIGN(sizeof(ifinfomsg))), [&](int type, Bytes value) {
    if (type == IFLA_TXQLEN) link.tx_queue = value_of<std::uint32_t>(value).value_or(0);
    if (type == IFLA_LINKINFO) take_kind(value, link);
  });
  return link;
}

CanLink read_link(const char* interface) {
  CanLink link;
  const unsigned index = ::if_nametoindex(interface);
  if (index == 0) {
    link.was_told = true;
    return link;
  }
  Request request;
  request.header.nlmsg_len = sizeof request;
  request.header.nlmsg_type = RTM_GETLINK;
  request.header.nlmsg_flags = NLM_F_REQUEST;
  request.link.ifi_index = static_cast<int>(index);
  const int handle = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (handle < 0) return link;
  const timeval patience{1, 0};
  (void)::setsockopt(handle, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::array<std::byte, 32'768> answer;
  ssize_t got = -1;
  if (::send(handle, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request)) {
    got = ::recv(handle, answer.data(), answer.size(), 0);
  }
  (void)::close(handle);
  return got > 0 ? parse_link(std::span(answer).first(static_cast<std::size_t>(got))) : link;
}

}  // namespace vergence::tools
