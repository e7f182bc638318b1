// What one address may have of a server's connections, without sockets.
#include "server/access/connection_table.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <string>
#include <vector>

namespace dynmesh::server::connection_table_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Arrival = ConnectionTable::Arrival;
using Sender = ConnectionTable::Sender;

PeerKey Peer(const std::string& address, int port) {
  return PeerKeyOf("ipv4:" + address + ":" + std::to_string(port)).value();
}

class ConnectionTableTest : public ::testing::Test {
 protected:
  void Make(const ConnectionTable::Limits& limits) {
    table_ = std::make_unique<ConnectionTable>(
        limits,
        ConnectionTable::System{[this](const auto& socket) { cut_.insert(socket.descriptor); },
                                [this](const auto& socket) { return !gone_.contains(socket); }});
  }
  static ConnectionTable::Socket SocketOf(int descriptor) {
    return {descriptor, static_cast<std::uint64_t>(descriptor)};
  }
  // gRPC closes it. A sweep notices that.
  void Close(int descriptor) { gone_.insert(SocketOf(descriptor)); }
  // Its descriptor and its port are the same number.
  Arrival Arrive(const std::string& address, int port) {
    const Arrival arrival = table_->Arrive({port, Peer(address, port), now_}, now_);
    if (arrival == Arrival::kEnters) table_->Enter(Peer(address, port), SocketOf(port), now_);
    return arrival;
  }
  // An address that had an answered call. Costs no place.
  void Know(const std::string& address) {
    constexpr int kPort = 60'000;
    ASSERT_EQ(Arrive(address, kPort), Arrival::kEnters);
    table_->Answered(Peer(address, kPort), now_);
    Close(kPort);
    table_->Sweep();
    gone_.clear();
  }
  std::vector<int> EnterReady() {
    const auto ready = table_->TakeReady(now_, [this](int socket) {
      return left_.contains(socket)     ? Sender::kLeft
             : silent_.contains(socket) ? Sender::kSilent
                                        : Sender::kReady;
    });
    closed_.insert(ready.close.begin(), ready.close.end());
    std::vector<int> entered;
    for (const auto& connection : ready.enter) {
      table_->Enter(connection.peer, SocketOf(connection.socket), now_);
      entered.push_back(connection.socket);
    }
    return entered;
  }

  ConnectionTable::Time now_{seconds(1000)};
  std::unique_ptr<ConnectionTable> table_;
  std::set<int> cut_, left_, silent_, closed_;
  struct Less {
    bool operator()(const ConnectionTable::Socket& a, const ConnectionTable::Socket& b) const {
      return std::pair(a.descriptor, a.cookie) < std::pair(b.descriptor, b.cookie);
    }
  };
  std::set<ConnectionTable::Socket, Less> gone_;
};

constexpr char kHere[] = "10.0.0.1";
constexpr char kThere[] = "10.0.0.2";

TEST(PeerKey, IsTheSameOfASocketAndOfTheTextOfGrpc) {
  EXPECT_EQ(ClientText(ClientKeyOf(Peer("10.1.2.3", 99))), "10.1.2.3");
  for (const char* text :
       {"ipv6:%5B2001:db8::7%5D:99", "ipv6:[2001:db8::7]:99", "ipv6:%5B2001:db8::7%25eth0%5D:99"}) {
    const auto key = PeerKeyOf(text);
    ASSERT_TRUE(key.has_value()) << text;
    EXPECT_EQ(key->port, 99);
    EXPECT_EQ(ClientText(ClientKeyOf(*key)), "2001:db8::/64") << text;
  }
  EXPECT_EQ(PeerKeyOf("ipv6:%5B::ffff:10.1.2.3%5D:99"), PeerKeyOf("ipv4:10.1.2.3:99"));
  for (const char* text : {"", "unix:/tmp/x", "ipv4:10.1.2.3", "ipv4:10.1.2:4", "ipv4:a:1",
                           "ipv6:%5B::1%5D:70000", "10.1.2.3:4"}) {
    EXPECT_FALSE(PeerKeyOf(text).has_value()) << text;
  }
}

TEST_F(ConnectionTableTest, AnAddressHasSoManyAndAnotherOneIsNotConcerned) {
  Make({.per_address = 2});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  EXPECT_EQ(Arrive(kHere, 2), Arrival::kEnters);
  EXPECT_EQ(Arrive(kHere, 3), Arrival::kRefused);
  EXPECT_EQ(Arrive(kThere, 4), Arrival::kEnters);
  Close(1);
  EXPECT_EQ(Arrive(kHere, 5), Arrival::kRefused);  // it has just looked
  now_ += milliseconds(100);
  EXPECT_EQ(Arrive(kHere, 6), Arrival::kEnters);
  EXPECT_EQ(table_->counts().open, 3u);
  EXPECT_EQ(table_->counts().refused, 2u);
  for (const int port : {2, 4, 6}) Close(port);
  table_->Sweep();
  EXPECT_EQ(table_->counts().open, 0u);
  EXPECT_FALSE(table_->HasUnanswered());
}

TEST_F(ConnectionTableTest, OfANewAddressConnectionsEnterOneAtATime) {
  Make({.new_per_second = 20});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  for (int port = 2; port <= 4; ++port) EXPECT_EQ(Arrive(kHere, port), Arrival::kWaits);
  EXPECT_EQ(Arrive(kThere, 9), Arrival::kEnters);  // other addresses are not concerned
  now_ += milliseconds(190);
  EXPECT_TRUE(EnterReady().empty());
  now_ += milliseconds(10);  // it may be one that makes no calls
  EXPECT_EQ(EnterReady(), std::vector<int>{4});
  Close(1);
  Close(4);
  now_ += milliseconds(60);
  EXPECT_EQ(EnterReady(), std::vector<int>{3});
  EXPECT_TRUE(EnterReady().empty());
  // From an answered call on several enter at once, for ten minutes.
  EXPECT_TRUE(table_->Answered(Peer(kHere, 3), now_));
  EXPECT_EQ(EnterReady(), std::vector<int>{2});
  for (int port = 5; port <= 8; ++port) EXPECT_EQ(Arrive(kHere, port), Arrival::kEnters);
  now_ += std::chrono::minutes(10);
  EXPECT_EQ(Arrive(kHere, 10), Arrival::kEnters);
  EXPECT_EQ(Arrive(kHere, 11), Arrival::kWaits);
}

TEST_F(ConnectionTableTest, NewConnectionsWithoutAnAnswerEnterAtARate) {
  Make({.new_per_second = 5});  // two at once
  Know(kHere);
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  EXPECT_EQ(Arrive(kHere, 2), Arrival::kEnters);
  EXPECT_EQ(Arrive(kHere, 3), Arrival::kWaits);
  EXPECT_EQ(Arrive(kHere, 4), Arrival::kWaits);
  EXPECT_EQ(Arrive(kThere, 5), Arrival::kEnters);
  EXPECT_TRUE(EnterReady().empty());
  now_ += milliseconds(200);
  EXPECT_EQ(EnterReady(), std::vector<int>{4});  // the newest
  // An answered call gives the place back, once.
  EXPECT_TRUE(table_->HasUnanswered());
  EXPECT_TRUE(table_->Answered(Peer(kHere, 1), now_));
  EXPECT_FALSE(table_->Answered(Peer(kHere, 1), now_));
  EXPECT_EQ(EnterReady(), std::vector<int>{3});
  EXPECT_FALSE(table_->HasWaiting());
  for (const int port : {2, 3, 4}) table_->Answered(Peer(kHere, port), now_);
  table_->Answered(Peer(kThere, 5), now_);
  EXPECT_FALSE(table_->HasUnanswered());
}

TEST_F(ConnectionTableTest, OneThatIsSilentDelaysNoOtherAndIsClosedInTheEnd) {
  Make({.new_per_second = 1, .silence = seconds(10)});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  for (const int port : {2, 3, 4}) EXPECT_EQ(Arrive(kHere, port), Arrival::kWaits);
  silent_ = {2};
  left_ = {3};
  EXPECT_TRUE(EnterReady().empty());
  EXPECT_EQ(closed_, std::set<int>{3});  // costs no place
  now_ += seconds(1);
  EXPECT_EQ(EnterReady(), std::vector<int>{4});
  now_ += seconds(8);
  EXPECT_TRUE(EnterReady().empty());
  EXPECT_EQ(closed_, std::set<int>{3});
  now_ += seconds(1);
  EXPECT_TRUE(EnterReady().empty());
  EXPECT_EQ(closed_, (std::set<int>{2, 3}));
  EXPECT_FALSE(table_->HasWaiting());
}

TEST_F(ConnectionTableTest, TooManyWastedCallsCutTheConnectionsThatBroughtThem) {
  Make({.wasted_per_second = 10});
  for (const int port : {1, 2, 3}) EXPECT_EQ(Arrive(kHere, port), Arrival::kEnters);
  EXPECT_EQ(Arrive(kThere, 4), Arrival::kEnters);
  table_->Answered(Peer(kHere, 2), now_);
  for (int i = 0; i < 10; ++i) {
    // A few of an answered one, as a proxy has of its clients.
    EXPECT_FALSE(table_->Wasted(Peer(kHere, i % 5 == 0 ? 2 : 1), now_));
  }
  EXPECT_TRUE(cut_.empty());
  EXPECT_FALSE(table_->Wasted(Peer(kHere, 2), now_));
  EXPECT_TRUE(table_->Wasted(Peer(kHere, 1), now_));
  EXPECT_EQ(cut_, std::set<int>{1});
  EXPECT_FALSE(table_->Wasted(Peer(kHere, 1), now_));  // it was still under way
  // Its new connections are refused for a second, those of others are not.
  EXPECT_EQ(Arrive(kHere, 5), Arrival::kRefused);
  EXPECT_EQ(Arrive(kThere, 6), Arrival::kEnters);
  now_ += milliseconds(900);
  EXPECT_EQ(Arrive(kHere, 7), Arrival::kRefused);
  now_ += milliseconds(100);
  EXPECT_EQ(Arrive(kHere, 8), Arrival::kWaits);  // for a call of 3
  EXPECT_TRUE(table_->Answered(Peer(kHere, 3), now_));
  EXPECT_EQ(EnterReady(), std::vector{8});
  const auto counts = table_->counts();
  EXPECT_EQ(counts.cut, 1u);
  EXPECT_EQ(counts.wasted, 13u);
  EXPECT_EQ(counts.open, 6u);
}

TEST_F(ConnectionTableTest, AfterTooManyWastedCallsConnectionsEnterOneAtATime) {
  Make({100, 20, 2});
  Know(kThere);
  ASSERT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  for (int i = 0; i < 3; ++i) table_->Wasted(Peer(kHere, 1), now_);
  ASSERT_EQ(cut_, std::set{1});
  now_ += milliseconds(1001);
  EXPECT_EQ(Arrive(kHere, 2), Arrival::kEnters);  // the one that was cut does not count
  for (int port = 3; port <= 6; ++port) EXPECT_EQ(Arrive(kHere, port), Arrival::kWaits);
  EXPECT_EQ(Arrive(kThere, 7), Arrival::kEnters);  // other addresses are not concerned
  EXPECT_EQ(Arrive(kThere, 8), Arrival::kEnters);
  now_ += seconds(1);
  EXPECT_TRUE(EnterReady().empty());
  EXPECT_TRUE(table_->Answered(Peer(kHere, 2), now_));
  EXPECT_EQ(EnterReady(), std::vector{6});  // the newest first, and no more than one
  EXPECT_TRUE(EnterReady().empty());
  Close(6);
  now_ += seconds(1);
  EXPECT_EQ(EnterReady(), std::vector{5});
  for (int i = 0; i < 3; ++i) table_->Wasted(Peer(kHere, 5), now_);
  EXPECT_EQ(cut_, (std::set{1, 5}));
  EXPECT_TRUE(EnterReady().empty());  // refused again
  EXPECT_EQ(closed_, (std::set{3, 4}));
  now_ += seconds(31);
  for (int port = 10; port <= 13; ++port) EXPECT_EQ(Arrive(kHere, port), Arrival::kEnters);
}

TEST_F(ConnectionTableTest, ConnectionsThatWaitAreRefusedWithTheirAddress) {
  Make({.new_per_second = 1, .wasted_per_second = 1});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  EXPECT_EQ(Arrive(kHere, 2), Arrival::kWaits);
  EXPECT_EQ(Arrive(kThere, 3), Arrival::kEnters);
  EXPECT_EQ(Arrive(kThere, 4), Arrival::kWaits);
  EXPECT_FALSE(table_->Wasted(Peer(kHere, 1), now_));
  EXPECT_TRUE(table_->Wasted(Peer(kHere, 1), now_));
  EXPECT_TRUE(EnterReady().empty());
  EXPECT_EQ(closed_, std::set<int>{2});
  now_ += seconds(1);
  EXPECT_EQ(EnterReady(), std::vector<int>{4});
}

TEST_F(ConnectionTableTest, AnAnsweredConnectionIsCutForManyWastedCallsOnly) {
  Make({.wasted_per_second = 10});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  table_->Answered(Peer(kHere, 1), now_);
  for (int i = 0; i < 99; ++i) EXPECT_FALSE(table_->Wasted(Peer(kHere, 1), now_)) << i;
  EXPECT_TRUE(table_->Wasted(Peer(kHere, 1), now_));
}

TEST_F(ConnectionTableTest, WastedCallsWithinTheRateCutNothing) {
  Make({.wasted_per_second = 10});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  for (int i = 0; i < 1000; ++i) {
    now_ += milliseconds(100);
    EXPECT_FALSE(table_->Wasted(Peer(kHere, 1), now_)) << i;
  }
  EXPECT_EQ(Arrive(kHere, 2), Arrival::kEnters);
}

// Ports and descriptors are used again before the end of the last connection is noticed.
TEST_F(ConnectionTableTest, APortAndADescriptorThatAreUsedAgainNameTheLastConnection) {
  Make({.wasted_per_second = 1});
  EXPECT_EQ(Arrive(kHere, 1), Arrival::kEnters);
  table_->Enter(Peer(kHere, 1), {77, 1077}, now_);
  table_->Enter(Peer(kThere, 5), {1, 1001}, now_);
  EXPECT_FALSE(table_->Wasted(Peer(kHere, 1), now_));
  EXPECT_TRUE(table_->Wasted(Peer(kHere, 1), now_));
  EXPECT_EQ(cut_, std::set<int>{77});
  EXPECT_EQ(table_->counts().open, 2u);
  EXPECT_FALSE(table_->Wasted(Peer(kThere, 5), now_));
  EXPECT_TRUE(table_->Wasted(Peer(kThere, 5), now_));
  EXPECT_EQ(cut_, (std::set<int>{1, 77}));
}

TEST_F(ConnectionTableTest, AddressesThatAreGoneAreForgotten) {
  Make({.new_per_second = 10, .wasted_per_second = 10});
  for (int i = 0; i < 100'000; ++i) {
    now_ += milliseconds(10);
    const std::string address = "10." + std::to_string(i >> 16) + "." +
                                std::to_string(i >> 8 & 255) + "." + std::to_string(i & 255);
    EXPECT_EQ(Arrive(address, i % 100), Arrival::kEnters);  // descriptors are used again
  }
  EXPECT_LT(table_->addresses(), 3'000u);
}

}  // namespace
}  // namespace dynmesh::server::connection_table_test
