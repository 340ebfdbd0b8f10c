"""A ROS 2 node that publishes a simulated scan ten times a second: `python ros_node.py "a bus ahead"`."""

import sys

import lidardraft
from lidardraft.ros import point_cloud2


def message(scan, header, cloud, field):
    """The PointCloud2 of a scan; `cloud` and `field` are the types of sensor_msgs.msg."""
    said = point_cloud2(scan)
    return cloud(header=header, **said | {"fields": [field(**each) for each in said["fields"]]})


if __name__ == "__main__":
    import rclpy
    from sensor_msgs.msg import PointCloud2, PointField
    from std_msgs.msg import Header

    rclpy.init()
    node = rclpy.create_node("lidardraft")
    publisher = node.create_publisher(PointCloud2, "lidar", 10)
    scan = lidardraft.simulate(lidardraft.layout_from_text(sys.argv[1]), lidardraft.Sensor.preset("os1-128"))

    def publish():
        header = Header(stamp=node.get_clock().now().to_msg(), frame_id="lidar")
        publisher.publish(message(scan, header, PointCloud2, PointField))

    node.create_timer(0.1, publish)
    rclpy.spin(node)
