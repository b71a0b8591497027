"""Publishers and subscriptions in the graph."""

from embedded_ros.endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum
from embedded_ros.public_names import shown_in

__all__ = ["TopicEndpointInfo", "TopicEndpointTypeEnum"]

shown_in(__name__, TopicEndpointInfo, TopicEndpointTypeEnum)
